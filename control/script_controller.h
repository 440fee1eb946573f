#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "control/gaze_controller.h"
#include "control/joint_limiter.h"

namespace saccade {

/// Configuration of ScriptController.
struct ScriptConfig {
  /// Tilt (+ up) and version (+ right) of each point; after the last one the first follows.
  std::vector<std::array<double, 2>> eyes_deg = {{-8, -8}, {8, -8}, {8, 8}, {-8, 8}};
  /// Neck pitch, roll and yaw of each point: as many as in eyes_deg, or none, and the neck stays.
  std::vector<std::array<double, 3>> neck_deg;
  double speed_deg_s = 40.0;  ///< mean speed of a move; its peak is 1.875 times that
  double dwell_s = 0.25;      ///< rest at every point
};

/// Keys: eyes_deg, neck_deg, speed_deg_s, dwell_s.
void describe(FieldVisitor& v, ScriptConfig& config);

/// Moves the eyes, and optionally the neck, through a list of points and ignores all targets. For scenes with a camera
/// that moves by itself, such as the eye-move data set of the paper (section III-A).
///
/// The joints rest for dwell_s, move to the first point with minimum jerk, rest, move to the next point, and after the
/// last one to the first. Vergence, and the neck without neck_deg, keep their positions of the first step.
class ScriptController final : public GazeController {
 public:
  /// Throws InputError for a configuration out of range.
  ScriptController(const ScriptConfig& config, const MotionLimits& limits);

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
