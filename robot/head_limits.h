#pragma once

#include <array>

#include "core/config.h"
#include "head/head_state.h"
#include "robot/robot.h"

namespace saccade {

/// Position limits of the head joints, deg, which apply in addition to the limits of the robot. Defaults: iCubGenova02.
struct HeadLimitsConfig {
  std::array<double, 2> neck_pitch_deg = {-30.0, 17.0};
  std::array<double, 2> neck_roll_deg = {-20.0, 20.0};
  std::array<double, 2> neck_yaw_deg = {-45.0, 45.0};
  std::array<double, 2> eyes_tilt_deg = {-30.0, 30.0};
  std::array<double, 2> eyes_version_deg = {-30.0, 30.0};
  std::array<double, 2> eyes_vergence_deg = {0.0, 50.0};
};

/// Keys: neck_pitch_deg, neck_roll_deg, neck_yaw_deg, eyes_tilt_deg, eyes_version_deg, eyes_vergence_deg.
void describe(FieldVisitor& v, HeadLimitsConfig& config);

/// Limits in radians. Those of the torso, which is not commanded, and of the speeds are infinite. Throws InputError for a
/// configuration out of range.
[[nodiscard]] JointLimits joint_limits(const HeadLimitsConfig& config);

/// Limits that apply to a head: of each joint the range that the robot and the configuration have in common.
struct CommonLimits {
  JointLimits limits;
  /// Passed if each joint has a range. Names the joints whose range the robot narrows, or that have none in common.
  StartUpCheck check;
};
/// `robot`: rad, as its board reports them; `ours`: the configured ones. Wider limits of the robot have no effect. Speeds
/// and the torso are those of `ours`.
[[nodiscard]] CommonLimits common_limits(const JointLimits& ours, const JointLimits& robot);

}  // namespace saccade
