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

/// The gate of the authors' own demo (2016): the median of the detections of the last quarter of a second,
/// and only while they are many and agree. Detections are compared in the image of now: those from before the
/// camera turned are moved to where it shows them now. (The demo left them where they were, so that for a
/// quarter of a second after a saccade the median lay between two images.)
struct AuthorsGateConfig {
  double window_s = 0.25;
  std::int64_t min_detections = 81;  ///< in the window ("more than 80")
  double max_spread_px = 20.0;       ///< standard deviation of x and of y over the window stays below
  double max_radius_px = 16.0;       ///< the largest radius of the window is taken, clipped here
  double max_target_x_m = -0.10;     ///< root frame; a target less far in front of the waist is moved there
};

/// A ball does not jump: once found, detections near where the last one was go through at once and those
/// elsewhere do not; to be found, and found again after it was lost, it has to be confirmed by detections that
/// agree. All in the root frame, so that the head's own motion does not matter, and as angles at the eye,
/// because depth from a radius is coarse.
struct ContinuityGateConfig {
  double tolerance_deg = 3.0;      ///< detections this close in bearing agree ...
  double depth_ratio = 1.4;        ///< ... if their distances differ by less than this factor
  double growth_deg_s = 60.0;      ///< the tolerance around the last one grows by this while none came
  double window_s = 0.20;          ///< how far back a confirmation may lie
  std::int64_t min_agreeing = 60;  ///< in the window, for the ball to be found
  double forget_s = 2.0;           ///< after so long without a detection near by the ball is lost
};

struct GateConfig {
  std::string gate = "continuity";  ///< none, authors or continuity
  AuthorsGateConfig authors;
  ContinuityGateConfig continuity;
  TargetConfig target;
};

/// Keys, beside each other in a scenario's gaze section: gate, authors_gate.*, continuity_gate.*, target.*.
void describe(FieldVisitor& v, GateConfig& config);

/// Makes the gate that `config` names.
/// `none`: every estimate at or above the threshold becomes a target, held ones included.
/// `authors`: estimates at or above the threshold enter the window, except held ones. The newest becomes a target if it
/// lies within one standard deviation of the median in x and in y.
/// `continuity`: estimates at or above the threshold become targets if the ball can have moved there.
/// Throws InputError for a configuration out of range.
[[nodiscard]] std::unique_ptr<GazeGate> make_gate(const GateConfig& config);

}  // namespace saccade
