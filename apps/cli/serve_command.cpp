#include "apps/cli/commands.h"
#include "apps/cli/web_option.h"
#include "apps/serve/serve_session.h"
#include "core/error.h"
#include "session/version.h"

namespace saccade {

void add_serve_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<ServeOptions>();
  Command command = line.add_command(
      "serve",
      "The simulated robot of a scenario, in real time, on YARP as if it were the iCub, or on a socket");
  command.option("scenario", options->scenario, "Scenario file (YAML)").required().offers_scenarios();
  command.option("--out", options->out, "Run folder; runs/NAME_served by default");
  command.option("--seed", options->seed, "Seed, instead of the scenario's");
  command.option("--set", options->assignments, "key.path=value, instead of the scenario's").one_value_each();
  command.flag("--force", options->force, "Replace an earlier run in that folder");
  add_web_option(command, options->web);
  command.flag("--wait-for-client", options->wait_for_client,
               "The world stands still until somebody reads the camera and takes the head");
  command.flag("--endless", options->endless,
               "Beyond the scenario's duration, until Ctrl-C, which is exit status 0");
  command.option(
      "--external", options->external,
      "Offer the robot at this HOST:PORT or path of a Unix socket instead, for the backend `external`");
  command.option("--robot", options->robot, "Ports /ROBOT/head/... and /ROBOT/torso/...").show_default();
  command.option("--gaze", options->gaze, "Ports /GAZE/... of the gaze controller").show_default();
  command.option("--camera", options->camera, "Port of the events").show_default();
  command.option("--format", options->format, "Of the events: packet, stamped_packet or vbottle")
      .show_default()
      .offers([]() -> std::vector<std::string> {
        return {"packet", "stamped_packet", "vbottle"};
      });
  command.option("--codec", options->codec, "Of their addresses: dvs_128, atis_20, atis_24 or ev2")
      .show_default()
      .offers([]() -> std::vector<std::string> {
        return {"dvs_128", "atis_20", "atis_24", "ev2"};
      });
  command.flag("--swap-polarity", options->swap_polarity,
               "Polarity bit 1 means brighter, as with event-driven's bridges to Prophesee cameras; without "
               "it 1 means "
               "darker");
  command.option("--state-period", options->state_period_ms, "Of the head's state ports, ms")
      .in_range(1.0, 100.0)
      .show_default();
  command.action([options, &registry]() -> int {
#ifndef SACCADE_YARP
    if (options->external.empty())
      throw InputError("serve", "a saccade built without YARP",
                       "--external ADDRESS, or one built where CMake finds YARP " +
                           std::string(least_yarp_version()) + " or newer");
#endif
    return serve(*options, registry);
  });
}

}  // namespace saccade
