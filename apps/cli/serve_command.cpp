#include "apps/cli/commands.h"
#include "apps/serve/serve_session.h"
#include "core/error.h"

namespace saccade {

void add_serve_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command = app.add_subcommand(
      "serve", "The simulated robot of a scenario on YARP, in real time, as if it were the iCub");
  command->add_option("scenario", options->scenario, "Scenario file (YAML)")->required();
  command->add_option("--out", options->out, "Run folder; runs/NAME_served by default");
  command->add_option("--seed", options->seed, "Seed, instead of the scenario's");
  command->add_option("--set", options->assignments, "key.path=value, instead of the scenario's")
      ->allow_extra_args(false);
  command->add_flag("--force", options->force, "Replace an earlier run in that folder");
  command->add_flag("--wait-for-client", options->wait_for_client,
                    "The world stands still until somebody reads the camera and takes the head");
  command->add_flag("--endless", options->endless, "Beyond the scenario's duration, until Ctrl-C");
  command->add_option("--robot", options->robot, "Ports /ROBOT/head/... and /ROBOT/torso/...")
      ->capture_default_str();
  command->add_option("--gaze", options->gaze, "Ports /GAZE/... of the gaze controller")
      ->capture_default_str();
  command->add_option("--camera", options->camera, "Port of the events")->capture_default_str();
  command->add_option("--format", options->format, "Of the events: packet, stamped_packet or vbottle")
      ->capture_default_str();
  command->add_option("--codec", options->codec, "Of their addresses: dvs_128, atis_20, atis_24 or ev2")
      ->capture_default_str();
  command->add_option("--state-period", options->state_period_ms, "Of the head's state ports, ms")
      ->check(CLI::Range(1.0, 100.0))
      ->capture_default_str();
  command->callback([options, &action] {
    action = [options]() -> int {
#ifdef SACCADE_YARP
      return serve(*options);
#else
      throw InputError("serve", "a saccade built without YARP",
                       "one built where CMake finds YARP 3.8 or newer");
#endif
    };
  });
}

}  // namespace saccade
