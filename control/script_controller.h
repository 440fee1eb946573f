#pragma once

#include <cstddef>
#include <vector>

#include "control/gaze_controller.h"

namespace saccade {

/// Moves the eyes, and optionally the neck, through a list of points and ignores all targets. For scenes with a camera
/// that moves by itself, such as the eye-move data set of the paper (section III-A).
///
/// The joints rest for dwell_s, move to the first point with minimum jerk, rest, move to the next point, and after the
/// last one to the first. Vergence, and the neck without neck_deg, keep their positions of the first step.
class ScriptController final : public GazeController {
 public:
  /// Throws InputError for a configuration out of range.
  ScriptController(const ScriptConfig& config, const JointLimits& limits);

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override;
  void rest() override {}
  [[nodiscard]] TargetStatus target_status() const override { return TargetStatus::none; }

 private:
  ScriptConfig config_;
  HeadJointVector min_rad_, max_rad_;
  std::optional<HeadJointVector> reference_rad_;
  HeadJointVector start_rad_ = HeadJointVector::Zero();  ///< at the first step
  HeadJointVector from_rad_ = HeadJointVector::Zero();   ///< where the move began
  std::size_t next_ = 0;  ///< point to which the eyes move, or at which they rest
  double move_s_ = 0.0;   ///< since the move began; below 0 in the rest at the start
};

}  // namespace saccade
