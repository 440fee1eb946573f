#include <filesystem>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/view/view.h"
#include "config/scenario.h"
#include "session/run_scenario.h"
#include "session/scenario_loop.h"

namespace saccade {
namespace {

struct RunOptions {
  std::filesystem::path scenario;
  std::optional<std::int64_t> seed;
  RunSettings settings;
  bool view = false;
};

int run(const RunOptions& options, const Registry& registry) {
  const Scenario scenario =
      read_scenario(options.scenario, options.settings.assignments, options.seed, registry);
  if (!options.view) {
    set_rasterisers(scenario.run.threads);
    return run_scenario(scenario, options.settings);
  }
  set_rasterisers(1);
  const std::filesystem::path& folder = options.settings.folder;
  View view(scenario.name, folder.empty() ? "." : folder.parent_path(), registry.detectors);
  set_rasterisers(scenario.run.threads);
  return view.show_run(scenario, [&](RunFeed& feed) {
    RunSettings settings = options.settings;
    settings.show = [&](const Tick& tick, const SimRobot& robot, const Loop& loop) {
      feed.record(tick, robot, loop);
    };
    settings.close = [&] { feed.close(); };
    return run_scenario(scenario, settings);
  });
}

}  // namespace

void add_run_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<RunOptions>();
  RunSettings& settings = options->settings;
  Command command = line.add_command("run", "One closed-loop run of a scenario, into a run folder");
  command.option("scenario", options->scenario, "Scenario file (YAML)").required().offers_scenarios();
  command.option("--out", settings.folder, "Run folder; runs/NAME by default");
  command.option("--seed", options->seed, "Seed, instead of the scenario's");
  command
      .option("--set", settings.assignments,
              "key.path=value, instead of the scenario's; null removes the key")
      .one_value_each();
  command.flag("--force", settings.force, "Replace an earlier run in that folder");
  command.flag("--view", options->view, "Show the run in a window");
  command.action([options, &registry] { return run(*options, registry); });
}

}  // namespace saccade
