#pragma once

#include <memory>

#include "apps/config/robot_file.h"
#include "robot/robot.h"

namespace saccade {

/// Connects to the robot that the file names. Throws InputError where this build has no such backend or a recording
/// cannot be played, RunError where the robot is not there.
[[nodiscard]] std::unique_ptr<Robot> open_robot(const RobotFile& file);

}  // namespace saccade
