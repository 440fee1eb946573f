#pragma once

#include <array>

#include "control/gaze_controller.h"
#include "control/minimum_jerk_filter.h"
#include "control/neck_solver.h"

namespace saccade {

/// The iCub's own gaze controller, which the paper used: neck and eyes apart, by design slow and smooth,
/// with saccades for what is far off.
///
/// - Every 20 ms, neck: NeckSolver's pose for the newest target, where that is more than 2.5 deg off the cyclopean
///   axis. A target within 5 deg waits for 0.25 s first; what comes meanwhile takes its place.
/// - Every 20 ms, eyes: v = 12.5/s pinv(J) (target - fixation point) over tilt, version and vergence, integrated
///   within limits into the eyes' reference; the fixation point is that of the reference. Vergence keeps 0.5 deg
///   from parallel. With `eyes: left`, the same for the left eye's axis alone, and vergence goes to rest.
/// - What the neck's motion would do to the gaze, by its commanded velocity, the eyes undo (there is no inertial
///   sensor): -pinv(J) J_neck v_neck, added to reference and command.
/// - Every 10 ms: a MinimumJerkFilter per joint turns reference - encoder into a velocity, which is integrated
///   into the position reference that goes out, within MotionLimits.
/// - Saccade: a new target whose eye pose is more than 10 deg from where the eyes look, not within 0.2 s of the
///   last one: the eyes go straight to tilt, version and vergence of the target, as fast as MotionLimits let them.
///   Then the eyes' controller starts again from the encoders.
///
/// Inner rates come from the time that has passed, so steps may have any length. A target that does not move is
/// looked at until it is exact; the original stops once neck and eyes are within 0.5 and 0.1 deg.
/// Source: formulas and constants of iKinGazeCtrl (icub-main, as of 2016).
class IkinGazeController final : public GazeController {
 public:
  /// Throws InputError.
  IkinGazeController(const IkinGazeConfig& config, const MotionLimits& limits);

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override;
  void rest() override;
  [[nodiscard]] TargetStatus target_status() const override { return status_; }

 private:
  using Eyes = Eigen::Vector3d;  ///< tilt, version, vergence
  struct EyeMotion {
    Eyes wanted_rad_s;   ///< towards the target
    Eyes counter_rad_s;  ///< against the neck's motion
  };

  void control(const JointVector& q);
  void plan_neck(const JointVector& q);
  void plan_eyes(const JointVector& q);
  void plan_saccade(const JointVector& q);
  void end_saccade(const JointVector& q);
  [[nodiscard]] EyeMotion both_eyes(const JointVector& q) const;
  [[nodiscard]] EyeMotion left_eye(const JointVector& q) const;
  [[nodiscard]] Eyes eyes_on_target(const JointVector& q) const;
  [[nodiscard]] Eyes inside_limits(const Eyes& eyes_rad) const;
  void integrate(const HeadJointVector& q, double dt_s);

  IkinGazeConfig config_;
  bool both_eyes_;
  MotionLimits limits_;
  HeadJointVector neutral_rad_;
  NeckSolver neck_solver_;
  std::array<MinimumJerkFilter, head_joint_count> filters_;

  bool started_ = false;
  TargetStatus status_ = TargetStatus::none;
  std::optional<Eigen::Vector3d> target_m_;
  double now_s_ = 0.0;
  double until_control_s_ = 0.0;  ///< of the next period of the filters
  bool plan_now_ = true;          ///< every other period

  HeadJointVector goal_rad_ = HeadJointVector::Zero();  ///< what the filters go to
  HeadJointVector goal_velocity_rad_s_ = HeadJointVector::Zero();
  HeadJointVector counter_rad_s_ = HeadJointVector::Zero();   ///< against the neck's motion
  HeadJointVector wanted_rad_s_ = HeadJointVector::Zero();    ///< held for a period
  HeadJointVector reference_rad_ = HeadJointVector::Zero();   ///< what goes out
  HeadJointVector velocity_rad_s_ = HeadJointVector::Zero();  ///< of it

  std::optional<double> neck_waits_since_s_;      ///< a target has come that the neck does not yet know
  std::optional<Eigen::Vector3d> neck_target_m_;  ///< one it knows and has not yet been turned to
  bool target_is_new_ = false;                    ///< no saccade has been considered for it
  bool saccade_ = false;
  double saccade_start_s_;
};

}  // namespace saccade
