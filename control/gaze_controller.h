#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/head_kinematics.h"
#include "control/joint_limiter.h"
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
  /// hardware. `state`: the newest encoder reading; if it is not finite, the last references are kept. `target_m`: a new
  /// point to look at, root frame, or none. dt_s: time since the last step, above 0.
  virtual HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                               double dt_s) = 0;
  /// Discards the target: the head moves to its neutral pose, as before the first target.
  virtual void rest() = 0;
  /// The status of the target of the last step: none, ok, or why it was rejected.
  [[nodiscard]] virtual TargetStatus target_status() const = 0;
};

/// From when on the head follows targets, and what it does when they cease to come.
struct FollowConfig {
  double start_s = 0.5;       ///< before it, camera and detector run in while the head keeps still
  std::string lost = "hold";  ///< hold: it keeps looking at the last target; rest: GazeController::rest
  double lost_after_s = 1.0;  ///< without a target, the last one is lost
};

/// Keys, beside each other in a scenario's gaze section: start_s, lost, lost_after_s.
void describe(FieldVisitor& v, FollowConfig& config);

/// Checks whether the head can look at a point (root frame). Returns not_finite, too_near (within 0.10 m of the left
/// eye), behind (not in front of the plane through the base of the neck normal to chest_forward()), or ok.
[[nodiscard]] TargetStatus check_gaze_target(const Eigen::Vector3d& target_m, const HeadKinematics& head);

/// Bounded velocity inverse kinematics, see QpController.
struct QpConfig {
  std::string eyes = "both";              ///< both: vergence on the target; left: vergence at rest
  double eye_time_constant_s = 0.08;      ///< in which the error of the gaze falls to 1 / e
  double neck_time_constant_s = 0.40;     ///< in which the neck takes over what the eyes are turned
  double right_eye_weight = 0.01;         ///< of the right eye's error against the left eye's
  double neck_weight = 1e-3;              ///< of the neck's own motion against the left eye's error
  double damping = 1e-5;                  ///< of every joint's velocity against the left eye's error
  double target_time_constant_s = 0.045;  ///< of what is known of the target's motion, see TargetTrack
  double max_lead_deg = 10.0;             ///< a reference runs no further ahead of the measured joint
};

/// Keys: eyes, eye_time_constant_s, neck_time_constant_s, right_eye_weight, neck_weight, damping,
/// target_time_constant_s, max_lead_deg.
void describe(FieldVisitor& v, QpConfig& config);

/// The iCub's own gaze controller, see IkinGazeController.
struct IkinGazeConfig {
  std::string eyes = "both";  ///< both: they meet on the target; left: that one aims, vergence at rest
  double neck_time_s = 0.75;  ///< of a neck's movement, MinimumJerkFilter's T
  double eyes_time_s = 0.25;  ///< of the eyes'
  bool saccades = true;
  double saccade_angle_deg = 10.0;  ///< a target that the eyes have to turn further to is a saccade's
  double saccade_interval_s = 0.2;  ///< from the start of one to that of the next at least
  double min_tilt_deg = -12.0;      ///< of the eyes, where the head's own limits are wider
  double max_tilt_deg = 15.0;
};

/// Keys: eyes, neck_time_s, eyes_time_s, saccades, saccade_angle_deg, saccade_interval_s, min_tilt_deg,
/// max_tilt_deg.
void describe(FieldVisitor& v, IkinGazeConfig& config);

/// Eyes that go their own way, see ScriptController.
struct ScriptConfig {
  /// Tilt (+ looks up) and version (+ looks right) to go to in turn, for ever.
  std::vector<std::vector<double>> eyes_deg = {{-8, -8}, {8, -8}, {8, 8}, {-8, 8}};
  /// Neck pitch, roll and yaw to go to at the same time: as many as points of the eyes, or none, and the neck stays.
  std::vector<std::vector<double>> neck_deg;
  double speed_deg_s = 40.0;  ///< mean of a move; its peak is 1.875 times that
  double dwell_s = 0.25;      ///< rest at every point
};

/// Keys: eyes_deg, neck_deg, speed_deg_s, dwell_s.
void describe(FieldVisitor& v, ScriptConfig& config);

struct GazeControllerConfig {
  std::string controller = "qp";  ///< qp, ikingaze or script
  QpConfig qp;
  IkinGazeConfig ikingaze;
  ScriptConfig script;
  MotionLimitsConfig limits;
};

/// Keys, beside each other in a scenario's gaze section: controller, qp.* or ikingaze.* or script.*,
/// limits.*.
void describe(FieldVisitor& v, GazeControllerConfig& config);

/// Throws InputError.
[[nodiscard]] std::unique_ptr<GazeController> make_gaze_controller(const GazeControllerConfig& config,
                                                                   const JointLimits& hardware);

}  // namespace saccade
