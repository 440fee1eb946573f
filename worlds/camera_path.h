#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "control/script_controller.h"
#include "sim/world.h"

namespace saccade {

/// The poses of the left eye while the head follows a script without error: for the draw of a world, before there is one.
class CameraPath {
 public:
  static constexpr std::int64_t step_us = 10'000;

  /// `script` may be null: the head stays at its initial pose.
  CameraPath(const ScriptConfig* script, const WorldConfig& world, double duration_s);

  /// The eye's pose at 0, step_us, 2 step_us, ... up to the duration.
  [[nodiscard]] const std::vector<Eigen::Isometry3d>& root_from_eye() const { return root_from_eye_; }

 private:
  std::vector<Eigen::Isometry3d> root_from_eye_;
};

/// How a ball looks along a path.
struct BallView {
  double in_view_share = 0.0;  ///< share of the instants with its centre in the image and no object before it
  double hidden_share = 0.0;   ///< share of the instants with its centre in the image and an object before it
  double smallest_px = 0.0;    ///< radius, over the instants at which any part is in the image
  double largest_px = 0.0;
  double fastest_px_s = 0.0;  ///< speed of its centre, as far as it is in the image
};

/// Projects the ball along the path. Objects hide it where their bounding box does; persons are behind it.
[[nodiscard]] BallView view_of(const CameraPath& path, const Camera& camera, const Trajectory& ball,
                               double radius_m, const NamedObjects& objects, std::uint64_t seed);

}  // namespace saccade
