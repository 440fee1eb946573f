#include <memory>

#include "apps/cli/commands.h"
#include "apps/deploy/guard_run.h"

namespace saccade {

void add_guard_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<GuardOptions>();
  Command command =
      line.add_command("guard", "Stops the head of a robot when deploy dies, hangs or is halted");
  command.option("robot", options->robot, "Robot file (YAML), the same as for deploy").required();
  command.option("--set", options->assignments, "key.path=value, instead of the robot file's")
      .one_value_each();
  command.option("--duration", options->duration_s, "Ends after so many seconds").positive();
  command.footer(
      "Start it before deploy, on the same machine. It stops the head if no tick of deploy comes for "
      "deploy.watchdog.hang_ms. docs/safety.md has the hazards and their bounds.");
  command.action([options, &registry] {
    guard(*options, registry);
    return 0;
  });
}

}  // namespace saccade
