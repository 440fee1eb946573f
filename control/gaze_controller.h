#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "control/delay_compensation.h"
#include "control/fixational_movement.h"
#include "control/head_kinematics.h"
#include "control/stabilisation.h"
#include "control/target.h"
#include "core/config.h"
#include "head/head_state.h"

namespace saccade {

/// Computes the references of the six neck and eye joints that turn the eyes to a point. step() neither allocates,
/// throws nor logs.
///
/// Before the first target the head moves to its neutral pose: all joints at 0, or as near to it as the limits allow.
/// Without new targets the eyes stay on the last one.
class GazeController {
 public:
  virtual ~GazeController() = default;
  /// Returns the position references, rad, from neck pitch to eyes vergence: always finite and within the limits of the
  /// hardware. `state`: the newest encoder reading; if it is none (is_reading), the last references are kept. `target_m`: a new
  /// point to look at, root frame, or none. dt_s: time since the last step, above 0; it counts as bounded_step_s(dt_s).
  virtual HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                               double dt_s) = 0;
  /// The delays from now on; 0 before the first call. Does nothing in a controller that compensates none.
  virtual void set_delays(const GazeDelays&) {}
  /// The motion of the body from the next step on; none before the first call. Does nothing in a controller that compensates
  /// none.
  virtual void set_body_rates(const BodyRates&) {}
  /// Multiplies the time constants by `factor`, at least 1, from the next step on. Does nothing in a controller with fixed
  /// ones.
  virtual void set_slowdown(double /*factor*/) {}
  /// Discards the target: the head moves to its neutral pose, as before the first target.
  virtual void rest() = 0;
  /// The status of the target of the last step: none, ok, or why it was rejected.
  [[nodiscard]] virtual TargetStatus target_status() const = 0;
  /// Why the controller has ended, so that it keeps its last references; empty while it works. Only controllers outside of
  /// this program can end.
  [[nodiscard]] virtual std::string_view failure() const { return {}; }
};

/// Whose optical axes a gaze controller points at the target.
enum class AimingEyes {
  both,  ///< vergence on the target
  left,  ///< the left eye aims; vergence moves to its rest position
};
constexpr auto words_of(AimingEyes) {
  return std::to_array<Word<AimingEyes>>({{AimingEyes::both, "both"}, {AimingEyes::left, "left"}});
}

/// What the head does when the target is lost.
enum class WhenLost {
  hold,  ///< it keeps looking at the last target
  rest,  ///< GazeController::rest
  search,  ///< it holds for a while, then looks at the points of a SearchScan in turn, until there is a target again
};
constexpr auto words_of(WhenLost) {
  return std::to_array<Word<WhenLost>>(
      {{WhenLost::hold, "hold"}, {WhenLost::rest, "rest"}, {WhenLost::search, "search"}});
}

/// From when on the head follows targets, and what it does when they cease to come.
struct FollowConfig {
  double start_s = 0.5;  ///< before it, camera and detector run in while the head keeps still
  WhenLost lost = WhenLost::hold;
  double lost_after_s = 1.0;    ///< without a target, the last one is lost
  double search_dwell_s = 1.5;  ///< lost: search looks at each point for so long
  DelayConfig delay = {};
  StabilisationConfig stabilisation = {};
  FixationalConfig fixational = {};
  bool detect_hunting = false;  ///< whether time constants grow when the head oscillates
};

/// Keys, beside each other in a scenario's gaze section: start_s, lost, lost_after_s, search_dwell_s, delay.*,
/// stabilisation.*, fixational.*, detect_hunting.
void describe(FieldVisitor& v, FollowConfig& config);

/// Longest distance of a gaze target from the left eye: ten times the longest that a locator of targets can be configured
/// for. The bearing of a farther point does not differ measurably, and its coordinates can overflow.
inline constexpr double farthest_target_m = 1000.0;

/// Checks whether the head can look at a point (root frame). Returns not_finite, too_far (farthest_target_m), too_near
/// (within 0.10 m of the left eye), behind (not in front of the plane through the base of the neck normal to
/// chest_forward()), or ok.
[[nodiscard]] TargetStatus check_gaze_target(const Eigen::Vector3d& target_m, const HeadKinematics& head);

}  // namespace saccade
