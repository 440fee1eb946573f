#include "apps/deploy/deploy_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "apps/deploy/deploy_loop.h"
#include "apps/deploy/deploy_recorder.h"
#include "apps/deploy/deploy_session.h"
#include "apps/deploy/guard_link.h"
#include "apps/deploy/hang_watch.h"
#include "apps/deploy/keyboard.h"
#include "apps/deploy/live_deploy.h"
#include "apps/live/live_message.h"
#include "config/robot_file.h"
#include "core/error.h"
#include "evaluation/report/report.h"
#include "robot/dry_robot.h"
#include "session/close_within.h"
#include "session/interrupt.h"
#include "session/real_time.h"
#include "session/run_folder.h"
#include "session/summary.h"
#include "session/version.h"

namespace saccade {
namespace {

bool print_checks(const std::vector<StartUpCheck>& checks) {
  for (const StartUpCheck& check : checks)
    fmt::print(stderr, "{}  {}: {}\n", check.passed ? "ok  " : "FAIL", check.what, check.found);
  return std::ranges::all_of(checks, &StartUpCheck::passed);
}

void print_keys(const DeployOptions& options, bool has_operator) {
  fmt::print(stderr, "{}{}\n", options.dry_run ? "dry run: nothing is sent to the head. " : "",
             has_operator       ? "Enter activates, space stops, q quits."
             : options.activate ? "Ctrl-C stops."
                                : "The head stays inactive: no terminal, and no --activate.");
}

/// Releases the joints at the end of its scope, whatever ends it.
class ReleaseAtEnd {
 public:
  explicit ReleaseAtEnd(Robot& robot) : robot_(robot) {}
  ReleaseAtEnd(const ReleaseAtEnd&) = delete;
  ReleaseAtEnd& operator=(const ReleaseAtEnd&) = delete;
  ~ReleaseAtEnd() { robot_.release(); }

 private:
  Robot& robot_;
};

/// After the head was stopped from outside of a tick that still hangs: nothing of this process can be saved any more.
[[noreturn]] void end_hung_program() {
  fmt::print(stderr, "the tick still hangs: deploy ends; the run folder stays incomplete\n");
  std::fflush(stderr);
  std::_Exit(1);
}

/// Ticks until the session ends. Without an operator a fault ends it, since nobody could activate the head again.
void run_session(DeploySession& session, OperatorRequests& requests, Clock& clock, std::int64_t end_us,
                 bool has_operator) {
  session.set_ready();
  while (session.tick()) {
    const bool faulted = session.state() == DeployState::stopped && is_fault(session.last_stop()->cause);
    if (interrupted()) requests.quit(StopCause::interrupted);
    if (clock.now_us() >= end_us || (faulted && !has_operator)) requests.quit(StopCause::ended);
  }
}

/// From the start-up checks to the report. `guard`: null if the head is not moved.
void deploy_on(Robot& robot, GuardLink* guard, const DeployOptions& options, const RobotFile& file) {
  const bool moves = guard != nullptr;
  DeployFacts facts;
  facts.checks = start_up_checks(robot, file);
  facts.dry_run = options.dry_run;
  facts.record = options.record;
  if (!print_checks(facts.checks)) throw RunError("not ready: see the start-up checks above");

  OperatorRequests requests;
  std::optional<LiveServer> server;  // before the folder is replaced: its address may be in use
  if (options.web) {
    server.emplace(LiveServer::Config{
        .address = *options.web, .page = live_page(), .stop = [&requests] { requests.stop(); }});
  }
  const std::filesystem::path folder =
      options.out.empty() ? std::filesystem::path("runs") / file.name : options.out;
  const auto lock = start_run_folder(folder, options.force, file.output.formats, "robot.yaml",
                                     version_line() + "\n" + resolved_robot_file(file));

  Loop loop = make_deploy_loop(robot, file);
  const Keyboard keyboard([&](char key) {
    if (key == 'q') requests.quit(StopCause::operator_stop);
    if (key == ' ') requests.stop();
    if (key == '\n') requests.activate();
  });
  const bool has_operator = Keyboard::is_there();
  print_keys(options, has_operator);
  // The writer's thread starts before this one gets its priority, so that it has none.
  DeployRecorder recorder(folder, file, loop, robot.events().image_size(), std::move(facts));
  // So do those of the page.
  LiveDeploy observer(recorder, server ? &*server : nullptr,
                      {.title = file.name,
                       .kind = "deploy",
                       .size = robot.events().image_size(),
                       .duration_s = options.duration_s,
                       .head = robot.head() != nullptr ? robot.head()->limits().head : nullptr},
                      file.deploy.watchdog, robot, loop);
  if (server) fmt::print(stderr, "live page: {}\n", server->link());
  HangWatch hang_watch(
      robot, {.bound_ns = std::llround(file.deploy.watchdog.hang_ms * 1e6)},
      [](std::int64_t age_ns) {
        fmt::print(stderr, "no tick for {:.1f} ms: the head was stopped\n",
                   1e-6 * static_cast<double>(age_ns));
      },
      end_hung_program);
  std::vector<Overseer*> overseers = {&hang_watch};
  if (moves) overseers.push_back(guard);
  DeploySession session(robot, loop, motion_maker(robot, file), requests, observer,
                        {std::llround(file.deploy.tick_ms * 1e3), file.deploy.watchdog, overseers, moves});
  {
    const ReleaseAtEnd release(robot);
    const RealTime real_time;
    fmt::print(stderr, "{}\n", real_time.summary());
    if (!real_time.granted()) {
      fmt::print(stderr,
                 "warning: other programs of this machine can delay the ticks, which stops the head: {}\n",
                 how_to_permit_real_time());
    }
    recorder.set_scheduling(real_time.summary());
    const std::int64_t end_us = options.duration_s
                                    ? robot.clock().now_us() + std::llround(*options.duration_s * 1e6)
                                    : std::numeric_limits<std::int64_t>::max();
    if (options.activate || options.dry_run)
      session.keep_activating(std::llround(file.deploy.activate_within_s * 1e6));
    run_session(session, requests, robot.clock(), end_us, has_operator);
  }
  recorder.finish();
  write_report(folder, file.output.formats);
  print_page(folder);
  if (session.state() == DeployState::stopped && is_fault(session.last_stop()->cause))
    throw RunError("the head was stopped: " + session.last_stop()->description());
  if (!session.not_activated().empty())
    throw RunError("the head was not activated: " + session.not_activated());
  std::string ended;
  for (const EndedProgram& program : recorder.ended())
    ended += (ended.empty() ? "" : "\n") + program.what + ": " + program.why;
  if (!ended.empty()) throw RunError(ended);
}

}  // namespace

void deploy(const DeployOptions& options, const Registry& registry) {
  const RobotFile file = read_robot_file(options.robot, options.assignments, registry);
  catch_interrupts();
  use_small_stacks();
  const bool moves = !options.dry_run && file.gaze.detector != "none" && !file.robot.head_name().empty();
  std::optional<GuardLink> guard;
  if (moves) {
    guard.emplace(file.robot.head_name(), file.deploy.guard,
                  std::llround(file.deploy.watchdog.hang_ms * 1e6));
  }
  std::unique_ptr<Robot> robot = open_robot(file.robot, robot_context(file));
  if (options.dry_run) robot = std::make_unique<DryRobot>(std::move(robot));
  const auto close = [&] { robot.reset(); };
  try {
    deploy_on(*robot, guard ? &*guard : nullptr, options, file);
  } catch (const std::exception& error) {
    close_within(longest_close, close, error.what());
    throw;
  }
  close_within(longest_close, close, {});
}

}  // namespace saccade
