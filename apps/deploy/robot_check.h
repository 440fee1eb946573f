#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/robot_file.h"
#include "robot/robot.h"

namespace saccade {

struct RobotCheckOptions {
  std::filesystem::path robot;
  std::vector<std::string> assignments;
  std::filesystem::path out = "runs";  ///< folder of the run folders
};

/// What deploy needs of this machine for a robot: YARP in this build, real-time priority, locked memory, processors, shared
/// memory, room on the disk of `out`, no other deploy, and the guard. Each missing thing says how to get it.
[[nodiscard]] std::vector<StartUpCheck> machine_checks(const RobotFile& file,
                                                       const std::filesystem::path& out);

/// All that deploy needs, each thing whether or not the one before is there: machine_checks(), the connection to the robot,
/// and the robot's own start-up checks (ports, camera, codec, joints, limits). Moves nothing. Throws InputError for a
/// broken robot file.
[[nodiscard]] std::vector<StartUpCheck> robot_checks(const RobotCheckOptions& options,
                                                     const Registry& registry);

}  // namespace saccade
