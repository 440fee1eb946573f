#pragma once

#include <array>

#include "core/config.h"
#include "head/head_state.h"

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

}  // namespace saccade
