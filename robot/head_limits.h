#pragma once

#include <vector>

#include "core/config.h"
#include "head/head_state.h"

namespace saccade {

/// The limits that we hold the head's joints to, whatever its own are: lowest and highest position, deg. The defaults
/// are those of iCubGenova02.
struct HeadLimitsConfig {
  std::vector<double> neck_pitch_deg = {-30.0, 17.0};
  std::vector<double> neck_roll_deg = {-20.0, 20.0};
  std::vector<double> neck_yaw_deg = {-45.0, 45.0};
  std::vector<double> eyes_tilt_deg = {-30.0, 30.0};
  std::vector<double> eyes_version_deg = {-30.0, 30.0};
  std::vector<double> eyes_vergence_deg = {0.0, 50.0};
};

/// Keys: neck_pitch_deg, neck_roll_deg, neck_yaw_deg, eyes_tilt_deg, eyes_version_deg, eyes_vergence_deg.
void describe(FieldVisitor& v, HeadLimitsConfig& config);

/// The torso's, which is not commanded, are wide open; speeds are not limited here. Throws InputError.
[[nodiscard]] JointLimits joint_limits(const HeadLimitsConfig& config);

}  // namespace saccade
