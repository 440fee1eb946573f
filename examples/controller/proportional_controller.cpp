#include "proportional_controller.h"

#include <cmath>

namespace example {

void describe(saccade::FieldVisitor& v, ProportionalConfig& config) {
  v.real("gain_per_s", config.gain_per_s, {0.1, 50.0},
         "share of the gaze error that the eyes correct per second");
}

ProportionalController::ProportionalController(const ProportionalConfig& config,
                                               const saccade::MotionLimits& limits)
    : config_(saccade::check_config("gaze.proportional", config)),
      limits_(limits),
      reference_rad_(saccade::inside_hardware(limits, saccade::HeadJointVector::Zero())) {}

saccade::HeadJointVector ProportionalController::step(const saccade::HeadState& state,
                                                      const std::optional<Eigen::Vector3d>& target_m,
                                                      double dt_s) {
  status_ = saccade::TargetStatus::none;
  if (!saccade::is_finite(state)) return reference_rad_;
  const saccade::HeadKinematics head(limits_.head->chain, state.position_rad);
  if (target_m) {
    status_ = saccade::check_gaze_target(*target_m, head);
    if (status_ == saccade::TargetStatus::ok) target_m_ = target_m;
  }
  if (!target_m_) return reference_rad_;
  const Eigen::Vector3d in_eye = head.root_from_eye(saccade::Eye::left).inverse() * *target_m_;
  const double right_rad = std::atan2(in_eye.x(), in_eye.z());
  const double up_rad = std::atan2(-in_eye.y(), in_eye.z());
  reference_rad_[saccade::head_index(saccade::eyes_tilt)] += config_.gain_per_s * dt_s * up_rad;
  reference_rad_[saccade::head_index(saccade::eyes_version)] += config_.gain_per_s * dt_s * right_rad;
  reference_rad_ = reference_rad_.cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad);
  return reference_rad_;
}

}  // namespace example
