#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/web_option.h"
#include "apps/deploy/deploy_run.h"

namespace saccade {

void add_deploy_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<DeployOptions>();
  Command command = line.add_command("deploy", "The loop in real time on a robot, into a run folder");
  command.option("robot", options->robot, "Robot file (YAML)").required();
  command.option("--out", options->out, "Run folder; runs/NAME by default");
  command.option("--set", options->assignments, "key.path=value, instead of the robot file's")
      .one_value_each();
  command.option("--duration", options->duration_s, "Ends after so many seconds").positive();
  command.flag("--dry-run", options->dry_run, "Everything but commands: nothing is sent to the head");
  command.flag("--record", options->record, "Record events and joints into the run folder, too");
  command.flag("--activate", options->activate, "Move the head as soon as it is ready, without a key");
  add_web_option(command, options->web);
  command.flag("--force", options->force, "Replace an earlier run in that folder");
  command.footer(
      "Keys: enter activates, space stops, q stops and quits, as Ctrl-C does. Exit status 1 if a fault "
      "stopped the head and it stayed stopped, or if it was not activated on request. docs/robot.md has the "
      "checklist before motors move, docs/safety.md the hazards.");
  command.action([options, &registry] {
    deploy(*options, registry);
    return 0;
  });
}

}  // namespace saccade
