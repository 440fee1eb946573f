#pragma once

#include <memory>
#include <optional>

#include "control/gaze_controller.h"
#include "control/joint_limiter.h"
#include "core/config.h"

namespace example {

/// A gaze controller for the eyes alone.
struct ProportionalConfig {
  double gain_per_s = 8.0;  ///< share of the gaze error that the eyes correct per second
};

void describe(saccade::FieldVisitor& v, ProportionalConfig& config);

/// Turns tilt and version of the eyes with a speed proportional to the angle between the left eye's optical axis and the
/// newest target. The neck and the vergence stay at their neutral position.
class ProportionalController final : public saccade::GazeController {
 public:
  /// Throws InputError for a configuration out of range.
  ProportionalController(const ProportionalConfig& config, const saccade::MotionLimits& limits);

  saccade::HeadJointVector step(const saccade::HeadState& state,
                                const std::optional<Eigen::Vector3d>& target_m, double dt_s) override;
  void rest() override { target_m_.reset(); }
  saccade::TargetStatus target_status() const override { return status_; }

 private:
  ProportionalConfig config_;
  saccade::MotionLimits limits_;
  saccade::HeadJointVector reference_rad_ = saccade::HeadJointVector::Zero();
  std::optional<Eigen::Vector3d> target_m_;  // root frame
  saccade::TargetStatus status_ = saccade::TargetStatus::none;
};

}  // namespace example
