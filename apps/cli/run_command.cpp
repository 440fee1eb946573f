#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/web_option.h"
#include "apps/live/live_feed.h"
#include "apps/live/live_message.h"
#include "apps/live/live_truth.h"
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
  std::optional<LiveAddress> web;
};

int run_with_page(const Scenario& scenario, const RunOptions& options) {
  LiveServer server({.address = *options.web, .page = live_page()});
  fmt::print(stderr, "live page: {}\n", server.link());
  const Camera& camera = scenario.sim.camera;
  LiveRun page{.title = scenario.name,
               .kind = "run",
               .size = camera.size,
               .both_eyes = scenario.sim.both_eyes(),
               .duration_s = scenario.run.duration_s,
               .head = head_model(scenario.sim.world.head),
               .principal_px = Eigen::Vector2d(camera.cx_px, camera.cy_px)};
  std::optional<LiveFeed> feed;
  RunSettings settings = options.settings;
  settings.show = [&](const Tick& tick, const SimRobot& robot, const Loop& loop) {
    if (!feed) feed.emplace(server, page, loop);
    feed->set_truth(live_truth(robot.truth(), camera, tick.target_m));
    feed->on_tick(tick);
  };
  settings.close = [&] { feed.reset(); };
  return run_scenario(scenario, settings);
}

int run(const RunOptions& options, const Registry& registry) {
  const Scenario scenario =
      read_scenario(options.scenario, options.settings.assignments, options.seed, registry);
  if (!options.view) {
    set_rasterisers(scenario.run.threads);
    return options.web ? run_with_page(scenario, options) : run_scenario(scenario, options.settings);
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
  Option view = command.flag("--view", options->view, "Show the run in a window");
  add_web_option(command, options->web).excludes(view);
  command.action([options, &registry] { return run(*options, registry); });
}

}  // namespace saccade
