#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/config/scenario.h"
#include "apps/session/interrupt.h"
#include "apps/session/log_file.h"
#include "apps/session/progress.h"
#include "apps/session/run_folder.h"
#include "apps/session/run_recorder.h"
#include "apps/session/scenario_loop.h"
#include "apps/session/summary.h"
#include "apps/session/version.h"
#include "apps/view/view.h"
#include "evaluation/report/report.h"
#include "loop/loop.h"
#include "loop/run_log.h"

namespace saccade {
namespace {

struct RunOptions {
  std::filesystem::path scenario;
  std::filesystem::path out;
  std::vector<std::string> assignments;
  std::optional<std::int64_t> seed;
  bool force = false;
  bool view = false;
};

/// Tables and figures, the log, and the window where there is one.
class Observers final : public LoopObserver {
 public:
  Observers(RunRecorder& recorder, RunLog& log, std::function<void(const Tick&)> show)
      : recorder_(recorder), log_(log), show_(std::move(show)) {}
  void on_tick(const Tick& tick) override {
    recorder_.on_tick(tick);
    log_.on_tick(tick);
    if (show_) show_(tick);
  }

 private:
  RunRecorder& recorder_;
  RunLog& log_;
  std::function<void(const Tick&)> show_;
};

/// `feed`: to the window; null without one.
int run_scenario(const RunOptions& options, const Scenario& scenario, RunFeed* feed) {
  const std::filesystem::path folder =
      options.out.empty() ? std::filesystem::path("runs") / scenario.name : options.out;
  const auto seed = static_cast<std::uint64_t>(scenario.seed);
  SimRobot robot(scenario.sim, seed);
  prepare_run_folder(folder, options.force);
  {
    OutputFile resolved(folder / "scenario.yaml");
    resolved.write(version_line() + "; " + robot.gl_description() + "\n" + resolved_scenario(scenario));
    resolved.commit();
  }
  Loop loop = make_loop(scenario, robot);
  RunRecorder recorder(folder, scenario, robot, loop);

  catch_interrupts();
  Progress progress(scenario.run.duration_s);
  LogFile log_file(folder / "log.txt", [&progress](const std::string& line) {
    progress.done();
    fmt::print(stderr, "{}\n", line);
  });
  RunLog log([&](std::int64_t t_us, const std::string& text) { log_file.write(t_us, text); });
  std::function<void(const Tick&)> show;
  if (feed != nullptr) show = [&](const Tick& tick) { feed->record(tick, robot, loop); };
  Observers observers(recorder, log, std::move(show));
  const std::int64_t end_us = std::llround(scenario.run.duration_s * 1e6);
  const auto begin = std::chrono::steady_clock::now();
  const auto wall_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() -
           recorder.picture_wall_s();
  };
  for (std::int64_t t_us = World::tick_us; t_us <= end_us && !interrupted(); t_us += World::tick_us) {
    if (loop.tick(t_us, observers) == PortStatus::lost)
      throw RunError("lost the connection to the " + std::string(loop.lost()));
    const double t_s = static_cast<double>(t_us) * 1e-6;
    progress.show(t_s, [&] {
      return fmt::format("{:6.2f} of {:.2f} s, {:.2f} x real time", t_s, scenario.run.duration_s,
                         t_s / std::max(wall_s(), 1e-9));
    });
  }
  const double loop_s = wall_s();
  if (feed != nullptr) feed->close();
  progress.done();
  log.finish();
  log_file.commit();
  const Metrics metrics = recorder.finish(loop_s, settings_of(options.assignments));
  write_report(folder);
  print_summary(metrics);
  fmt::print("{}\n", (folder / "report.html").string());
  if (interrupted()) throw RunError("interrupted; the run folder holds what happened until then");
  const std::vector<std::string> unmet = unmet_expectations(scenario, metrics);
  for (const std::string& line : unmet) fmt::print(stderr, "saccade: {}\n", line);
  return unmet.empty() ? 0 : 3;
}

int run(const RunOptions& options, const Registry& registry) {
  const Scenario scenario = read_scenario(options.scenario, options.assignments, options.seed, registry);
  std::optional<View> view;
  if (options.view) {
    set_rasterisers(1);
    view.emplace(scenario.name, options.out.empty() ? "." : options.out.parent_path(), registry.detectors);
  }
  set_rasterisers(scenario.run.threads);
  if (!view) return run_scenario(options, scenario, nullptr);
  return view->show_run(scenario, [&](RunFeed& feed) { return run_scenario(options, scenario, &feed); });
}

}  // namespace

void add_run_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<RunOptions>();
  Command command = line.add_command("run", "One closed-loop run of a scenario, into a run folder");
  command.option("scenario", options->scenario, "Scenario file (YAML)").required();
  command.option("--out", options->out, "Run folder; runs/NAME by default");
  command.option("--seed", options->seed, "Seed, instead of the scenario's");
  command.option("--set", options->assignments, "key.path=value, instead of the scenario's").one_value_each();
  command.flag("--force", options->force, "Replace an earlier run in that folder");
  command.flag("--view", options->view, "Show the run in a window");
  command.action([options, &registry] { return run(*options, registry); });
}

}  // namespace saccade
