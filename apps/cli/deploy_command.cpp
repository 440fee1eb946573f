#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/config/robot_file.h"
#include "apps/deploy/deploy_recorder.h"
#include "apps/deploy/deploy_session.h"
#include "apps/deploy/keyboard.h"
#include "apps/deploy/open_robot.h"
#include "apps/deploy/real_time.h"
#include "apps/session/interrupt.h"
#include "apps/session/run_folder.h"
#include "apps/session/scenario_loop.h"
#include "apps/session/version.h"
#include "core/error.h"
#include "evaluation/report/report.h"
#include "loop/loop.h"
#include "robot/dry_robot.h"

namespace saccade {
namespace {

struct DeployOptions {
  std::filesystem::path robot, out;
  std::vector<std::string> assignments;
  std::optional<double> duration_s;
  bool dry_run = false;
  bool record = false;
  bool activate = false;
  bool force = false;
};

std::string in_words(ImageSize size) { return fmt::format("{} x {} pixels", size.width, size.height); }

/// The robot's own checks and those that need the file.
std::vector<StartUpCheck> start_up_checks(Robot& robot, const RobotFile& file) {
  std::vector<StartUpCheck> checks = robot.check();
  const Camera& camera = file.calibration.camera;
  const ImageSize size = robot.events().image_size();
  checks.push_back({"calibration is of this camera", size == camera.size,
                    size == camera.size ? in_words(size)
                                        : fmt::format("events of {}, calibration of {}", in_words(size),
                                                      in_words(camera.size))});
  const bool drives = file.gaze.detector != "none";
  const bool has_head = robot.head() != nullptr;
  checks.push_back({"a head, where gaze.detector drives one", has_head || !drives,
                    has_head ? "there is one"
                    : drives ? "none"
                             : "none, and none is needed"});
  return checks;
}

bool print_checks(const std::vector<StartUpCheck>& checks) {
  for (const StartUpCheck& check : checks)
    fmt::print(stderr, "{}  {}: {}\n", check.passed ? "ok  " : "FAIL", check.what, check.found);
  return std::ranges::all_of(checks, &StartUpCheck::passed);
}

std::optional<std::size_t> driver_of(const RobotFile& file) {
  for (std::size_t i = 0; i < file.detectors.size(); ++i) {
    if (file.detectors[i].first == file.gaze.detector) return i;
  }
  return std::nullopt;
}

/// What moves the head; empty where nothing shall.
DeploySession::MakeMotion motion_maker(Robot& robot, const RobotFile& file) {
  if (!driver_of(file) || robot.head() == nullptr) return {};
  return [&robot, &file] {
    LoopMotion motion;
    motion.ramp_in_s = file.deploy.ramp_in_s;
    if (GazePort* const port = robot.gaze()) {
      motion.port = port;
    } else {
      const JointLimits limits = robot.head()->limits();
      motion.controller = make_gaze_controller(file.gaze.controller, limits);
      motion.limiter.emplace(motion_limits(limits, file.gaze.controller.limits));
    }
    return motion;
  };
}

Loop make_loop(Robot& robot, const RobotFile& file) {
  std::optional<LoopGaze> gaze;
  if (const auto driver = driver_of(file); driver && robot.head() != nullptr)
    gaze.emplace(LoopGaze{driver, make_gate(file.gaze.gate), std::nullopt, file.gaze.follow});
  const LoopBudget budget{static_cast<std::size_t>(file.deploy.max_events_per_tick),
                          std::llround(file.deploy.shadows_until_ms * 1e3)};
  return Loop(robot, file.calibration, make_detectors(file.detectors, file.calibration.camera),
              std::move(gaze), Eye::left, budget);
}

/// Gives the joints back however the run ends.
class ReleaseAtEnd {
 public:
  explicit ReleaseAtEnd(Robot& robot) : robot_(robot) {}
  ReleaseAtEnd(const ReleaseAtEnd&) = delete;
  ReleaseAtEnd& operator=(const ReleaseAtEnd&) = delete;
  ~ReleaseAtEnd() { robot_.release(); }

 private:
  Robot& robot_;
};

int deploy(const DeployOptions& options, const Registry& registry) {
  const RobotFile file = read_robot_file(options.robot, options.assignments, registry);
  catch_interrupts();
  std::unique_ptr<Robot> robot = open_robot(file);
  if (options.dry_run) robot = std::make_unique<DryRobot>(std::move(robot));
  DeployFacts facts;
  facts.checks = start_up_checks(*robot, file);
  facts.dry_run = options.dry_run;
  facts.record = options.record;
  if (!print_checks(facts.checks)) throw RunError("not ready: see the start-up checks above");

  const std::filesystem::path folder =
      options.out.empty() ? std::filesystem::path("runs") / file.name : options.out;
  prepare_run_folder(folder, options.force);
  {
    OutputFile resolved(folder / "robot.yaml");
    resolved.write(version_line() + "\n" + resolved_robot_file(file));
    resolved.commit();
  }

  Loop loop = make_loop(*robot, file);
  Operator wishes;
  const Keyboard keyboard([&](char key) {
    if (key == 'q') wishes.quit(StopCause::operator_stop);
    if (key == ' ') wishes.stop();
    if (key == '\n') wishes.activate();
  });
  const bool attended = Keyboard::is_there();
  if (options.activate || options.dry_run) wishes.activate();
  fmt::print(stderr, "{}{}\n", options.dry_run ? "dry run: nothing is sent to the head. " : "",
             attended           ? "Enter activates, space stops, q quits."
             : options.activate ? "Ctrl-C stops."
                                : "Nobody can activate it: no terminal, and not --activate.");
  // The writer's thread starts before this one gets its priority, so that it has none.
  DeployRecorder recorder(folder, file, loop, robot->events().image_size(), std::move(facts));
  DeploySession session(*robot, loop, motion_maker(*robot, file), wishes, recorder,
                        {std::llround(file.deploy.tick_ms * 1e3), file.deploy.watchdog});
  bool stopped_by_fault = false;
  {
    const ReleaseAtEnd release(*robot);
    const RealTime real_time;
    fmt::print(stderr, "{}\n", real_time.told());
    recorder.set_scheduling(real_time.told());
    const std::int64_t end_us = options.duration_s
                                    ? robot->clock().now_us() + std::llround(*options.duration_s * 1e6)
                                    : std::numeric_limits<std::int64_t>::max();
    session.set_ready();
    while (session.tick()) {
      stopped_by_fault = session.state() == DeployState::stopped && is_fault(session.last_stop()->cause);
      if (interrupted()) wishes.quit(StopCause::interrupted);
      // Nobody is there who could activate it again.
      if (robot->clock().now_us() >= end_us || (stopped_by_fault && !attended)) wishes.quit(StopCause::ended);
    }
  }
  if (session.state() == DeployState::stopped) stopped_by_fault = is_fault(session.last_stop()->cause);
  recorder.finish();
  write_report(folder);
  fmt::print("{}\n", (folder / "report.html").string());
  if (stopped_by_fault) throw RunError("the head was stopped: " + session.last_stop()->description());
  return 0;
}

}  // namespace

void add_deploy_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<DeployOptions>();
  Command command = line.add_command("deploy", "The loop in real time on a robot, into a run folder");
  command.option("robot", options->robot, "Robot file (YAML)").required();
  command.option("--out", options->out, "Run folder; runs/NAME by default");
  command.option("--set", options->assignments, "key.path=value, instead of the robot file's")
      .one_value_each();
  command.option("--duration", options->duration_s, "Ends after so many seconds").positive();
  command.flag("--dry-run", options->dry_run, "Everything but commands: nothing is sent to the head");
  command.flag("--record", options->record, "Events and joints into the run folder, too");
  command.flag("--activate", options->activate, "Moves the head as soon as it is ready, without a key");
  command.flag("--force", options->force, "Replace an earlier run in that folder");
  command.footer(
      "Keys: enter activates, space stops, q stops and quits, as Ctrl-C does. Exit status 1 where the head "
      "was "
      "stopped by a fault and stayed so. docs/robot.md has the checklist before motors move.");
  command.action([options, &registry] { return deploy(*options, registry); });
}

}  // namespace saccade
