#pragma once

#include <array>

#include "control/gaze_controller.h"
#include "control/joint_limiter.h"
#include "control/minimum_jerk_filter.h"
#include "control/neck_solver.h"

namespace saccade {

/// Configuration of IkinGazeController.
struct IkinGazeConfig {
  AimingEyes eyes = AimingEyes::both;
  double neck_time_s = 0.75;  ///< duration of a neck movement, T of MinimumJerkFilter
  double eyes_time_s = 0.25;  ///< duration of an eye movement
  bool saccades = true;
  double saccade_angle_deg = 10.0;  ///< a target further from the current eye pose starts a saccade
  double saccade_interval_s = 0.2;  ///< least time between the starts of two saccades
  double min_tilt_deg = -12.0;      ///< of the eyes, where the head's own limits are wider
  double max_tilt_deg = 15.0;
};

/// Keys: eyes, neck_time_s, eyes_time_s, saccades, saccade_angle_deg, saccade_interval_s, min_tilt_deg,
/// max_tilt_deg.
void describe(FieldVisitor& v, IkinGazeConfig& config);

/// The gaze controller of the iCub (iKinGazeCtrl), which the paper used: slow, smooth movements of neck and eyes, and
/// saccades to distant targets.
///
/// - Every 20 ms, neck: the pose of NeckSolver for the newest target, if that is more than 2.5 deg off the cyclopean
///   axis. A target within 5 deg is applied after 0.25 s; a newer target replaces it meanwhile.
/// - Every 20 ms, eyes: v = 12.5/s pinv(J) (target - fixation point) over tilt, version and vergence, integrated
///   within limits into the reference of the eyes; the fixation point is that of the reference. Vergence is at least 0.5
///   deg. With `eyes: left`, the same for the axis of the left eye only, and vergence moves to its rest position.
/// - The eyes compensate the commanded motion of the neck: -pinv(J) J_neck v_neck is added to reference and command. With
///   set_body_rates() the motion of torso and base is added to that of the neck.
/// - Every 10 ms: a MinimumJerkFilter per joint turns reference - encoder into a velocity. Its integral, within
///   MotionLimits, is the position reference that step() returns.
/// - Saccade: if the eye pose for a new target is more than 10 deg from the current one, and at least 0.2 s after the
///   last saccade, the eyes move to tilt, version and vergence of the target as fast as MotionLimits allow. Then the
///   controller of the eyes restarts from the encoders.
///
/// Periods are measured in the time that the caller passes, so steps can have any length. The error for a resting target
/// converges to 0; the original stops when neck and eyes are within 0.5 and 0.1 deg.
/// Source: formulas and constants of iKinGazeCtrl (icub-main, as of 2016).
class IkinGazeController final : public GazeController {
 public:
  /// Throws InputError.
  IkinGazeController(const IkinGazeConfig& config, const MotionLimits& limits);

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override;
  void set_body_rates(const BodyRates& rates) override { body_ = rates; }
  /// Gains of the eyes' compensation, as `vor` and `ocr` of iKinGazeCtrl: of the rotation of set_head_rotation(), and of the
  /// commanded motion of the neck. 0 and 1 before the first call.
  void set_counter_gains(double vor, double ocr) {
    vor_ = vor;
    ocr_ = ocr;
  }
  /// The rotation of the head that its gyroscope measures, rad/s, root frame; 0 before the first call. The eyes compensate it
  /// as a rotation about the midpoint of the eyes.
  void set_head_rotation(const Eigen::Vector3d& rad_s) { head_rad_s_ = rad_s; }
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
  HeadJointVector neutral_rad_ = HeadJointVector::Zero();
  NeckSolver neck_solver_;
  std::array<MinimumJerkFilter, head_joint_count> filters_;

  BodyRates body_;
  double vor_ = 0.0;
  double ocr_ = 1.0;
  Eigen::Vector3d head_rad_s_ = Eigen::Vector3d::Zero();
  bool started_ = false;
  TargetStatus status_ = TargetStatus::none;
  std::optional<Eigen::Vector3d> target_m_;
  double now_s_ = 0.0;
  double until_control_s_ = 0.0;  ///< of the next period of the filters
  bool plan_now_ = true;          ///< every other period

  HeadJointVector goal_rad_ = HeadJointVector::Zero();  ///< goal of the filters
  HeadJointVector goal_velocity_rad_s_ = HeadJointVector::Zero();
  HeadJointVector counter_rad_s_ = HeadJointVector::Zero();   ///< against the neck's motion
  HeadJointVector wanted_rad_s_ = HeadJointVector::Zero();    ///< held for a period
  HeadJointVector reference_rad_ = HeadJointVector::Zero();   ///< the reference that step() returns
  HeadJointVector velocity_rad_s_ = HeadJointVector::Zero();  ///< of it

  std::optional<double> neck_waits_since_s_;  ///< a target has come that the neck does not follow yet
  std::optional<Eigen::Vector3d>
      neck_target_m_;           ///< a target that the neck has accepted and not yet moved to
  bool target_is_new_ = false;  ///< no saccade has been considered for it
  bool saccade_ = false;
  double saccade_start_s_;
};

}  // namespace saccade
