#pragma once

#include "control/bounded_qp.h"
#include "control/gaze_controller.h"
#include "control/target_track.h"

namespace saccade {

/// Chooses, every step, the joint velocities v of neck and eyes that minimise
///
///     |J v + e' + e / T_eye|^2       left eye: bearing e of the target to the optical axis, two rows; e' is
///                                    what the target's own velocity makes of it (TargetTrack)
///   + w_right (...)^2                right eye: the target's azimuth, with `eyes: both`
///   + w_neck |w_head - eyes / T_neck|^2   the neck turns the head to where the eyes are turned, levels its
///   roll
///   + damping |v|^2
///
/// within the velocities that MotionLimits allow (position, speed, acceleration, braking), exactly. The eyes
/// are cheap, so they jump to the target; the neck follows with a slower time constant while the eyes
/// counter-turn; where the eyes meet a limit the first term recruits the neck. At rest no term pulls against
/// the first one, so the left eye has no steady error for a target it can reach.
///
/// Errors and Jacobians are of the measured joints, velocities are integrated into references: a joint that
/// sags under a load is lifted until the gaze is right. A reference waits for its joint at max_lead_deg.
class QpController final : public GazeController {
 public:
  /// Throws InputError.
  QpController(const QpConfig& config, const MotionLimits& limits);

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override;
  void rest() override { target_.forget(); }
  [[nodiscard]] TargetStatus target_status() const override { return status_; }

 private:
  using Qp = BoundedQp<head_joint_count>;

  /// The sum of squares above as 1/2 v'Hv - g'v.
  struct Cost {
    Qp::Matrix h = Qp::Matrix::Zero();
    Qp::Vector g = Qp::Vector::Zero();

    void add(double weight, const Eigen::Matrix<double, 1, head_joint_count>& row, double wanted) {
      h += weight * row.transpose() * row;
      g += weight * wanted * row.transpose();
    }
  };

  [[nodiscard]] Cost gaze_cost(const HeadKinematics& head, const HeadJointVector& q) const;
  [[nodiscard]] Cost neutral_cost(const HeadJointVector& q) const;
  void integrate(const Cost& cost, const HeadJointVector& q, double dt_s);

  QpConfig config_;
  bool both_eyes_;
  double max_lead_rad_;
  MotionLimits limits_;
  Qp qp_;
  bool started_ = false;
  TargetStatus status_ = TargetStatus::none;
  TargetTrack target_;
  HeadJointVector reference_rad_ = HeadJointVector::Zero();
  HeadJointVector velocity_rad_s_ = HeadJointVector::Zero();
};

}  // namespace saccade
