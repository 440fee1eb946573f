// Seeded random faults of a deployed robot in virtual time: COUNT [SEED] [TABLE.md]. Prints a table of the times to the
// safe state by class of fault. Status 1 if a fault was not answered as docs/safety.md says.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/deploy/deploy_session.h"
#include "control/controller_registry.h"
#include "control/head_kinematics.h"
#include "control/open_gate.h"
#include "core/random.h"
#include "core/units.h"
#include "tests/control/genova02.h"
#include "tests/deploy/fake_deployed.h"

namespace saccade {
namespace {

constexpr double most_ms = 100.0;          // from a fault to the stop, and no reference later
constexpr double rest_deg_s = 1.0;         // of every joint ...
constexpr std::int64_t rest_us = 250'000;  // ... so long after the stop
constexpr std::int64_t longest_us = 4'000'000;

/// Sees a ball on a circle, so that the head always moves.
class CircleSeer final : public Detector {
 public:
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    estimate_ = {};
    if (motion == nullptr) return;
    const double turn_rad = 4e-6 * static_cast<double>(now_us);
    const Eigen::Vector3d ball_m(-0.5, 0.12 * std::cos(turn_rad), 0.35 + 0.08 * std::sin(turn_rad));
    const auto circle = Camera{}.project_sphere(motion->root_from_camera.inverse() * ball_m, 0.0475);
    if (circle) estimate_ = {true, true, *circle, 1.0};
  }
  [[nodiscard]] Estimate estimate() override { return estimate_; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  Estimate estimate_;
};

class Ignore final : public DeployObserver {
 public:
  void on_tick(const Tick&, const TickTiming&) override {}
  void on_change(const DeployChange&) override {}
  void on_news(std::int64_t, const std::string&) override {}
};

/// A guard, or a watch, that demands a stop from a time on.
class Demand final : public Overseer {
 public:
  explicit Demand(const Clock& clock) : clock_(clock) {}
  void on_tick() override {}
  std::optional<Fault> fault() override {
    if (!fault_ || clock_.now_us() < from_us_) return std::nullopt;
    fault_->amount = 1e-3 * static_cast<double>(clock_.now_us() - from_us_);
    return fault_;
  }
  void set(StopCause cause, std::int64_t from_us) {
    fault_ = Fault{cause, 0, {}, 0.0};
    from_us_ = from_us;
  }

 private:
  const Clock& clock_;
  std::optional<Fault> fault_;
  std::int64_t from_us_ = 0;
};

enum class Kind {
  camera_silent,
  joints_frozen,
  encoder_not_a_number,
  joint_outside,
  joint_off,
  joint_fault,
  joint_taken,
  command_refused,
  joint_stuck,
  tick_late,
  connection_lost,
  guard_lost,
  guard_stops,
  operator_stops,
  operator_quits,
  count
};
constexpr std::array<const char*, static_cast<std::size_t>(Kind::count)> names = {
    "camera silent",        "joint readings frozen",
    "encoder not a number", "joint outside its limits",
    "joint switched off",   "joint in hardware fault",
    "joint's mode changed", "reference rejected",
    "joint stuck",          "tick late",
    "connection lost",      "guard lost",
    "stop by the guard",    "operator stops",
    "operator quits"};

struct Faults {
  FakeRobotScript script;
  std::optional<std::pair<StopCause, std::int64_t>> demand;
  std::optional<std::int64_t> stop_us, quit_us;
  std::vector<std::pair<Kind, std::int64_t>> list;

  void demand_stop(StopCause cause, std::int64_t at_us) {
    if (!demand || at_us < demand->second) demand = {cause, at_us};
  }
};

void add(Faults& faults, Kind kind, std::int64_t at_us, const RandomStream& random, std::uint64_t trial) {
  FakeRobotScript& script = faults.script;
  switch (kind) {
    case Kind::camera_silent:
      script.silent_us = at_us;
      break;
    case Kind::joints_frozen:
      script.freeze_us = at_us;
      break;
    case Kind::encoder_not_a_number:
      script.nan_us = {at_us, at_us + 1'000 + static_cast<std::int64_t>(random.uniform(0.0, 2e5, 90, trial))};
      break;
    case Kind::joint_outside:
      script.outside_us = at_us;
      break;
    case Kind::joint_off:
      script.drive_us = {at_us, JointDrive::off};
      break;
    case Kind::joint_fault:
      script.drive_us = {at_us, JointDrive::fault};
      break;
    case Kind::joint_taken:
      script.drive_us = {at_us, JointDrive::held};
      break;
    case Kind::command_refused:
      script.refuse_us = at_us;
      break;
    case Kind::joint_stuck:
      script.stuck_us = at_us;
      break;
    case Kind::tick_late:
      script.late_us = {at_us, static_cast<std::int64_t>(random.uniform(21e3, 95e3, 91, trial))};
      break;
    case Kind::connection_lost:
      script.lost_us = at_us;
      break;
    case Kind::guard_lost:
      faults.demand_stop(StopCause::guard_lost, at_us);
      break;
    case Kind::guard_stops:
      faults.demand_stop(StopCause::guard_stops, at_us);
      break;
    case Kind::operator_stops:
      faults.stop_us = at_us;
      break;
    case Kind::operator_quits:
    case Kind::count:
      faults.quit_us = at_us;
      break;
  }
  faults.list.emplace_back(kind, at_us);
}

Faults make_faults(const RandomStream& random, std::uint64_t trial) {
  Faults faults;
  faults.script.limits = genova02_limits();
  faults.script.lag_s = random.uniform(0.01, 0.06, 0, trial);
  const auto count = 1 + (random.bits(1, trial) % 4 == 0 ? 1 + random.bits(2, trial) % 2 : 0);
  const std::int64_t first_us = static_cast<std::int64_t>(random.uniform(2e5, 1.5e6, 3, trial));
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto kind = static_cast<Kind>(random.bits(10 + i, trial) % static_cast<std::uint64_t>(Kind::count));
    const bool again = std::ranges::any_of(faults.list, [&](const auto& f) { return f.first == kind; });
    if (again) continue;
    const auto later_us = i == 0 ? 0.0 : random.uniform(0.0, 8e4, 20 + i, trial);
    add(faults, kind, first_us + static_cast<std::int64_t>(later_us), random, trial);
  }
  return faults;
}

struct Result {
  double stop_ms = 0.0;      ///< from the first fault
  double took_ms = 0.0;      ///< from its fact
  std::string problem = {};  ///< empty: safe
  bool stops = true;         ///< false where a stuck joint did not have to move
};

Result run(const Faults& faults, bool with_gaze) {
  FakeDeployed robot(faults.script, with_gaze);
  std::vector<LoopDetector> detectors;
  detectors.push_back({"seer", std::make_unique<CircleSeer>()});
  Loop loop(
      robot, MountedCamera{}, std::move(detectors),
      LoopGaze{0, std::make_unique<OpenGate>(TargetConfig{}), std::nullopt, FollowConfig{.start_s = 0.0}});
  const auto motion = [&] {
    if (with_gaze) return LoopMotion{nullptr, std::nullopt, robot.gaze()};
    return LoopMotion{make_gaze_controller(built_in_controllers().config(), faults.script.limits),
                      JointLimiter(motion_limits(faults.script.limits, {}))};
  };
  OperatorRequests requests;
  Ignore ignore;
  Demand demand(robot.clock());
  if (faults.demand) demand.set(faults.demand->first, faults.demand->second);
  DeploySessionConfig config;
  config.overseers = {&demand};
  DeploySession session(robot, loop, motion, requests, ignore, config);
  session.set_ready();
  requests.activate();

  // A stuck joint is a fault when it does not follow: nothing has to happen where it need not move.
  const bool only_stuck = faults.list.size() == 1 && faults.list[0].first == Kind::joint_stuck;
  bool goes_on = true;
  std::int64_t last_tick_us = 0;  // before the stop
  while (goes_on && robot.stops == 0 && robot.clock().now_us() < longest_us) {
    const std::int64_t now_us = robot.clock().now_us();
    last_tick_us = robot.stops == 0 ? now_us : last_tick_us;
    if (faults.stop_us && now_us >= *faults.stop_us) requests.stop();
    if (faults.quit_us && now_us >= *faults.quit_us) requests.quit(StopCause::operator_stop);
    goes_on = session.tick();
  }
  std::int64_t first_us = INT64_MAX;
  for (const auto& [kind, at_us] : faults.list) {
    if (kind != Kind::joint_stuck || only_stuck) first_us = std::min(first_us, at_us);
  }
  Result result;
  if (robot.stops == 0 && only_stuck) {
    result.stops = false;
    return result;
  }
  if (robot.stops == 0) {
    result.problem = "no stop";
    return result;
  }
  // The watch in a thread of its own (HangWatch) stops the head first if the tick comes too late.
  const std::int64_t hang_us = last_tick_us + std::llround((WatchdogConfig{}.hang_ms + 2.0) * 1e3);
  robot.first_stop_us = std::min(robot.first_stop_us, hang_us);
  result.stop_ms = std::max(0.0, 1e-3 * static_cast<double>(robot.first_stop_us - first_us));
  result.took_ms = 1e-3 * static_cast<double>(robot.first_stop_us - session.last_stop()->since_us);
  const bool lags = session.last_stop()->cause == StopCause::joint_lags;
  if (lags ? session.last_stop()->amount > WatchdogConfig{}.joint_lag_ms + 2.0 : result.stop_ms > most_ms)
    result.problem = "late: " + session.last_stop()->description();
  const int commands = robot.commands;
  const std::size_t targets = robot.targets.size();
  const std::int64_t until_us = robot.first_stop_us + rest_us;
  while (goes_on && robot.clock().now_us() < until_us) goes_on = session.tick();
  if (robot.commands != commands || robot.targets.size() != targets) result.problem = "moved after the stop";
  if (robot.commands_while_not_active > 0) result.problem = "a command while it was not active";
  HeadState head;
  const bool readable = !faults.script.lost_us && !faults.script.freeze_us && !faults.script.nan_us;
  if (goes_on && readable && !with_gaze) {
    robot.head()->read(head);
    if (head.velocity_rad_s.cwiseAbs().maxCoeff() > rest_deg_s * rad_per_deg) result.problem = "not at rest";
  }
  if (robot.is_active) result.problem = "not released";
  return result;
}

struct Class {
  std::vector<double> stop_ms;
  int unsafe = 0;
};

std::string table_of(std::map<std::string, Class>& classes, std::uint64_t count, std::uint64_t seed) {
  std::string table = fmt::format(
      "{} random faults, seed {}, virtual time. From the fault to the stop command, ms.\n\n"
      "| class | faults | median | 99.9 % | worst | unsafe |\n|---|---|---|---|---|---|\n",
      count, seed);
  for (auto& [name, found] : classes) {
    std::ranges::sort(found.stop_ms);
    const auto quantile = [&](double share) {
      const auto at = static_cast<std::size_t>(share * static_cast<double>(found.stop_ms.size()));
      return found.stop_ms[std::min(at, found.stop_ms.size() - 1)];
    };
    table += fmt::format("| {} | {} | {:.1f} | {:.1f} | {:.1f} | {} |\n", name, found.stop_ms.size(),
                         quantile(0.5), quantile(0.999), found.stop_ms.back(), found.unsafe);
  }
  return table;
}

}  // namespace
}  // namespace saccade

int main(int count_of_arguments, char** arguments) {
  using namespace saccade;
  const std::uint64_t count = count_of_arguments > 1 ? std::strtoull(arguments[1], nullptr, 10) : 1000;
  const std::uint64_t seed = count_of_arguments > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1;
  const RandomStream random(seed, "fault campaign");
  std::map<std::string, Class> classes;
  int unsafe = 0;
  for (std::uint64_t trial = 0; trial < count; ++trial) {
    const Faults faults = make_faults(random, trial);
    // With a gaze controller of the robot's own deploy sends no references to joints.
    const bool needs_joints = std::ranges::any_of(faults.list, [](const auto& f) {
      return f.first == Kind::joint_taken || f.first == Kind::command_refused || f.first == Kind::joint_stuck;
    });
    const Result result = run(faults, !needs_joints && random.bits(4, trial) % 4 == 0);
    std::string name = names[static_cast<std::size_t>(faults.list[0].first)];
    if (faults.list.size() > 1) name = "several at once";
    Class& found = classes[name];
    if (result.stops) found.stop_ms.push_back(result.stop_ms);
    if (result.problem.empty()) continue;
    ++found.unsafe;
    if (++unsafe <= 20) {
      fmt::print(stderr, "fault {}: {}", trial, result.problem);
      for (const auto& [kind, at_us] : faults.list)
        fmt::print(stderr, "; {} at {} us", names[static_cast<std::size_t>(kind)], at_us);
      fmt::print(stderr, "\n");
    }
  }
  const std::string table = table_of(classes, count, seed);
  fmt::print("{}", table);
  if (count_of_arguments > 3) std::ofstream(arguments[3]) << table;
  return unsafe == 0 ? 0 : 1;
}
