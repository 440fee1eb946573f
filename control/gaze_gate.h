#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "control/target.h"
#include "core/camera.h"
#include "core/config.h"
#include "core/detector.h"

namespace saccade {

/// How many detections at or above the threshold a gate rejected, by reason.
struct RejectedTargets {
  std::int64_t not_finite = 0;
  std::int64_t bad_radius = 0;
  std::int64_t too_near = 0;
  std::int64_t behind = 0;
  std::int64_t too_far = 0;
  std::int64_t in_body = 0;
};

/// Decides which detections become gaze targets. Its update neither allocates nor throws.
class GazeGate {
 public:
  virtual ~GazeGate() = default;
  /// Called at least once per tick with the observation of the tick, or an invalid estimate if there is none (no event,
  /// and no held estimate). `now_us` never decreases. Returns a new point to look at, m, root frame, or none.
  virtual std::optional<Eigen::Vector3d> update(std::int64_t now_us, const Estimate& estimate,
                                                double threshold, const Camera& camera,
                                                const Eigen::Isometry3d& root_from_cam) = 0;
  [[nodiscard]] virtual RejectedTargets rejected() const = 0;
};

}  // namespace saccade
