#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "head/head_description.h"

namespace saccade {

/// The ergoCub's head of a version, SN001 or SN003: three joints of the torso, neck pitch, roll and yaw, the tilt of the one
/// camera. The eye is the camera's frame (realsense_rgb_frame). `version` is one of ergocub_versions().
/// Sources: urdf/ergoCub/robots/ergoCubSN001 and SN003 of mesh-iit/ergocub-software (BSD-3), 2026-03: chain and limits;
/// robots-configuration, ergoCubSN001: the speeds of torso and neck. The speed of the tilt and all servos' bandwidths are
/// estimates.
[[nodiscard]] HeadDescription ergocub_description(std::string_view version);
[[nodiscard]] const std::vector<std::string>& ergocub_versions();

}  // namespace saccade
