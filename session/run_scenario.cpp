#include "session/run_scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/warnings.h"
#include "loop/run_log.h"
#include "session/failure_log.h"
#include "session/interrupt.h"
#include "session/log_file.h"
#include "session/progress.h"
#include "session/run_folder.h"
#include "session/run_recorder.h"
#include "session/scenario_loop.h"
#include "session/session.h"
#include "session/version.h"

namespace saccade {
namespace {

/// Calls a function at the end of its scope, whatever ends it.
class AtEnd {
 public:
  explicit AtEnd(const std::function<void()>& action) : action_(action) {}
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;
  ~AtEnd() {
    if (action_) action_();
  }

 private:
  const std::function<void()>& action_;
};

/// Passes each tick to a function.
class TickFunction final : public LoopObserver {
 public:
  explicit TickFunction(std::function<void(const Tick&)> function) : function_(std::move(function)) {}
  void on_tick(const Tick& tick) override { function_(tick); }

 private:
  std::function<void(const Tick&)> function_;
};

std::int64_t duration_us(const Scenario& scenario) { return std::llround(scenario.run.duration_s * 1e6); }

}  // namespace

int run_scenario(const Scenario& scenario, const RunSettings& settings) {
  const std::filesystem::path folder =
      settings.folder.empty() ? std::filesystem::path("runs") / scenario.name : settings.folder;
  SimRobot robot(scenario.sim, static_cast<std::uint64_t>(scenario.seed),
                 static_cast<std::size_t>(scenario.run.threads));
  Loop loop = make_loop(scenario, robot);  // throws before there is a folder
  const auto lock = start_run_folder(folder, settings.force, scenario.output.formats, "scenario.yaml",
                                     version_line() + ", " + SimRobot::simulator_version() + "; " +
                                         robot.gl_description() + "\n" + resolved_scenario(scenario));
  const AtEnd close(settings.close);
  RunRecorder recorder(folder, scenario, robot, loop);

  catch_interrupts();
  Progress progress(scenario.run.duration_s);
  LogFile log_file(folder / "log.txt", [&](const std::string& line) { progress.print_line(line); });
  for (const std::string& warning : warnings_of(scenario)) log_file.write(0, "warning: " + warning);
  RunLog log([&](std::int64_t t_us, const std::string& text) { log_file.write(t_us, text); });
  FailureLog failures(loop, [&](std::int64_t t_us, const std::string& what, const std::string& why) {
    log_file.write(t_us, what + ": " + why);
  });
  Session session(robot, loop);
  const auto loop_wall_s = [&] { return session.wall_s() - recorder.picture_wall_s(); };
  TickFunction show([&](const Tick& tick) {
    if (settings.show) settings.show(tick, robot, loop);
    const double t_s = static_cast<double>(tick.t_us) * 1e-6;
    progress.show(t_s, [&] {
      return fmt::format("{:6.2f} of {:.2f} s, {:.2f} x real time", t_s, scenario.run.duration_s,
                         t_s / std::max(loop_wall_s(), 1e-9));
    });
  });
  session.add_observer(recorder);
  session.add_observer(log);
  session.add_observer(failures);
  session.add_observer(show);
  session.run(World::tick_us, duration_us(scenario));
  const double wall_s = loop_wall_s();
  if (settings.close) settings.close();
  progress.done();
  log.finish();
  log_file.commit();
  const Metrics metrics = recorder.finish(wall_s, settings_of(settings.assignments));
  finish_run_folder(folder, metrics, scenario.output.formats);
  const std::vector<std::string> unmet = unmet_expectations(scenario, metrics);
  for (const std::string& line : unmet) fmt::print(stderr, "saccade: {}\n", line);
  return unmet.empty() ? 0 : 3;
}

Metrics score_scenario(const Scenario& scenario, const std::optional<std::filesystem::path>& folder,
                       const std::function<void(std::vector<LoopDetector>&)>& wrap) {
  SimRobot robot(scenario.sim, static_cast<std::uint64_t>(scenario.seed),
                 static_cast<std::size_t>(scenario.run.threads));
  std::vector<LoopDetector> detectors = make_detectors(scenario.detectors, scenario.calibration.camera);
  if (wrap) wrap(detectors);
  Loop loop = make_loop(scenario, robot, std::move(detectors), make_gaze(scenario, robot.limits()));
  RunRecorder recorder(folder, scenario, robot, loop);
  Session session(robot, loop);
  session.add_observer(recorder);
  session.run(World::tick_us, duration_us(scenario));
  return recorder.finish(session.wall_s() - recorder.picture_wall_s(), {});
}

}  // namespace saccade
