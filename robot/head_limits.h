#pragma once

#include <array>

#include "core/config.h"
#include "head/head_model.h"
#include "robot/robot.h"

namespace saccade {

/// Position limits of the joints that gaze commands, deg, which apply in addition to the limits of the robot.
struct HeadLimitsConfig {
  HeadLimitsConfig() : HeadLimitsConfig(default_head()) {}
  /// The limits of a head's description.
  explicit HeadLimitsConfig(std::shared_ptr<const HeadModel> model);

  std::shared_ptr<const HeadModel> head;
  std::array<std::array<double, 2>, gaze_slots> range_deg{};  ///< of each joint, the neck first
};

/// Keys: the name of each joint that gaze commands with the suffix _deg.
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
