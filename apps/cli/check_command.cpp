#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/deploy/robot_check.h"

namespace saccade {

void add_check_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<RobotCheckOptions>();
  Command command =
      line.add_command("check", "What is missing on this machine and network for deploy on a robot");
  command.option("robot", options->robot, "Robot file (YAML)").required();
  command.option("--set", options->assignments, "key.path=value, instead of the robot file's")
      .one_value_each();
  command.option("--out", options->out, "Folder of the run folders, whose disk is checked").show_default();
  command.footer(
      "Checks YARP, real-time priority, locked memory, disk and guard, then connects to the robot and checks "
      "its ports, camera and joints. Nothing moves. Exit status 1 if something is missing.");
  command.action([options, &registry] {
    const auto checks = robot_checks(*options, registry);
    for (const StartUpCheck& check : checks)
      fmt::print("{}  {}: {}\n", check.passed ? "ok  " : "FAIL", check.what, check.found);
    return std::ranges::all_of(checks, &StartUpCheck::passed) ? 0 : 1;
  });
}

}  // namespace saccade
