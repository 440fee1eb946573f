#pragma once

#include <cstddef>
#include <vector>

#include "control/gaze_controller.h"

namespace saccade {

/// Moves the eyes, and the neck where it is told to, from point to point without looking, whatever a detector says: for scenes in which the
/// camera moves by itself, such as the paper's eye-move data set (section III-A).
///
/// They rest, go to the first point, rest, go to the next, and after the last to the first again. A move has
/// minimum jerk. What has no points stays where it is at the first step: vergence, and the neck without neck_deg.
class ScriptController final : public GazeController {
 public:
  /// Throws InputError for a configuration out of range.
  ScriptController(const ScriptConfig& config, const JointLimits& limits);

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override;
  void rest() override {}  // there is nothing to forget
  [[nodiscard]] TargetStatus target_status() const override { return TargetStatus::none; }

 private:
  ScriptConfig config_;
  HeadJointVector min_rad_, max_rad_;
  std::optional<HeadJointVector> reference_rad_;
  HeadJointVector start_rad_ = HeadJointVector::Zero();  ///< at the first step
  HeadJointVector from_rad_ = HeadJointVector::Zero();   ///< where the move began
  std::size_t next_ = 0;                                 ///< point that the eyes go to or rest at
  double move_s_ = 0.0;  ///< since the move began; below 0 in the rest at the start
};

}  // namespace saccade
