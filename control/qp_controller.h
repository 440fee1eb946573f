#pragma once

#include <vector>

#include "control/bounded_qp.h"
#include "control/gaze_controller.h"
#include "control/joint_limiter.h"
#include "control/reference_history.h"
#include "control/target_predictor.h"

namespace saccade {

/// Configuration of QpController.
struct QpConfig {
  AimingEyes eyes = AimingEyes::both;
  double eye_time_constant_s = 0.08;        ///< in which the gaze error falls to 1 / e
  double neck_time_constant_s = 0.40;       ///< in which the neck takes over the rotation of the eyes
  double right_eye_weight = 0.01;           ///< of the right eye's error relative to the left eye's
  double neck_weight = 1e-3;                ///< of the neck's motion relative to the left eye's error
  double damping = 1e-5;                    ///< of every joint's velocity relative to the left eye's error
  double target_time_constant_s = 0.045;    ///< of the estimate of the target's velocity, see TargetTrack
  double max_lead_deg = 10.0;               ///< largest distance from the measured joint to its reference
  bool predict_motion = true;               ///< whether periodic motion and free fall are predicted
  double catch_up_deg = 0.0;                ///< gaze error that starts a catch-up saccade; 0: none
  double catch_up_time_constant_s = 0.025;  ///< eye_time_constant_s during a catch-up saccade
};

/// Keys: eyes, eye_time_constant_s, neck_time_constant_s, right_eye_weight, neck_weight, damping,
/// target_time_constant_s, max_lead_deg, predict_motion, catch_up_deg, catch_up_time_constant_s.
void describe(FieldVisitor& v, QpConfig& config);

/// Bounded velocity inverse kinematics. Every step computes the joint velocities v of neck and eyes that minimise
///
///     |J v + e' + e / T_eye|^2       left eye: bearing e of the target relative to the optical axis, two rows; e' is
///                                    its rate caused by the velocity of the target (TargetTrack)
///   + w_right (...)^2                right eye: the target's azimuth, with `eyes: both`
///   + w_neck |w_head - eyes / T_neck|^2   the neck turns the head towards the direction of the eyes and levels it
///   + damping |v|^2
///
/// exactly within the velocities that MotionLimits allow (position, speed, acceleration, braking). Eye motion has a low
/// cost, so the eyes move to the target first; the neck follows with a longer time constant while the eyes turn back. If
/// the eyes are at a limit, the first term moves the neck. At rest all other terms vanish, so the left eye has no
/// steady-state error for a target within reach.
///
/// Errors and Jacobians use the measured joints, and velocities are integrated into references. So the controller
/// compensates a steady position error of a joint. A reference leads its joint by max_lead_deg at most.
///
/// Delays of set_delays() are compensated: targets are predicted to the instant at which a reference moves the eyes
/// (TargetPredictor), and measured joints are moved on by what their references have changed but the joints have not
/// followed yet (ReferenceHistory, a Smith predictor).
///
/// Motion of the body (set_body_rates): the rate e' includes what torso and base turn the eye, and targets are tracked in a
/// frame that does not turn with the base.
///
/// Catch-up saccade: when the gaze error exceeds catch_up_deg for 20 ms, at most every 0.15 s, the time constant of the
/// eyes is catch_up_time_constant_s until the error is below a quarter of catch_up_deg, for 0.1 s at most.
class QpController final : public GazeController {
 public:
  /// Throws InputError.
  QpController(const QpConfig& config, const MotionLimits& limits);

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override;
  void set_delays(const GazeDelays& delays) override { delays_ = delays; }
  void set_body_rates(const BodyRates& rates) override { body_ = rates; }
  void set_slowdown(double factor) override;
  void rest() override { target_.forget(); }
  [[nodiscard]] TargetStatus target_status() const override { return status_; }

 private:
  using Row = Eigen::Matrix<double, 1, gaze_slots>;

  /// The sum of squares above as 1/2 v'Hv - g'v.
  struct Cost {
    explicit Cost(int count, double damping) : joints(count) { h.diagonal().setConstant(damping); }

    int joints;
    Eigen::Matrix<double, gaze_slots, gaze_slots> h = Eigen::Matrix<double, gaze_slots, gaze_slots>::Zero();
    HeadJointVector g = HeadJointVector::Zero();

    void add(double weight, const Row& row, double wanted);
  };

  /// What a joint of the eyes does in a cost; follows from the chain.
  struct EyeJoint {
    int index;        ///< among the joints of the gaze
    Eye eye;          ///< the first eye that it turns
    bool turns_left;  ///< whether it turns the left eye
    bool conjugate;   ///< whether it turns the eyes together, or the only eye: the neck takes over from it
  };

  [[nodiscard]] Cost gaze_cost(const HeadKinematics& head, const HeadJointVector& q);
  [[nodiscard]] Cost neutral_cost(const HeadJointVector& q) const;
  [[nodiscard]] HeadJointVector solve(const Cost& cost, const HeadJointVector& slowest,
                                      const HeadJointVector& fastest);
  void integrate(const Cost& cost, const HeadJointVector& q, double dt_s);
  [[nodiscard]] HeadJointVector joints_ahead(const HeadJointVector& q, double dt_s) const;
  void update_catch_up(double error_rad);

  QpConfig config_;
  bool both_eyes_;
  bool aims_right_elevation_ = false;  ///< the right eye has a tilt of its own
  std::vector<EyeJoint> eye_joints_;
  std::vector<int> levelled_;  ///< joints of the neck that turn about the optical axis: roll
  double max_lead_rad_;
  MotionLimits limits_;
  /// One of the two, by the number of joints.
  BoundedQp<head_joint_count> small_qp_;
  BoundedQp<gaze_slots> large_qp_;
  bool started_ = false;
  TargetStatus status_ = TargetStatus::none;
  TargetPredictor target_;
  GazeDelays delays_;
  BodyRates body_;
  ReferenceHistory history_;
  double slowdown_ = 1.0;
  bool catching_up_ = false;
  double catch_up_since_s_ = 1.0;  ///< since the start of the last catch-up saccade
  double behind_s_ = 0.0;          ///< for how long the gaze error has been above catch_up_deg
  HeadJointVector reference_rad_ = HeadJointVector::Zero();
  HeadJointVector velocity_rad_s_ = HeadJointVector::Zero();
};

}  // namespace saccade
