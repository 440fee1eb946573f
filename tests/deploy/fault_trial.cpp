#include "tests/deploy/fault_trial.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/deploy/deploy_session.h"
#include "apps/deploy/guard_link.h"
#include "control/controller_registry.h"
#include "control/head_kinematics.h"
#include "control/open_gate.h"
#include "core/units.h"
#include "head/icub_cameras.h"
#include "tests/deploy/disk_fault.h"
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
    const auto circle = icub_left_2016.project_sphere(motion->root_from_camera.inverse() * ball_m, 0.0475);
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

/// The guard and deploy's link to it in virtual time: GuardWatch decides when the guard stops the head.
class ModelGuard final : public Overseer {
 public:
  /// `killed_us`: from then on it does not look any more.
  ModelGuard(FakeDeployed& robot, std::optional<std::int64_t> killed_us)
      : robot_(robot), killed_us_(killed_us) {}

  /// The guard looks at the board.
  void look() {
    if (!lives()) return;
    board_.guard_ns = now_ns();
    const std::uint64_t moving = board_.moving;
    if (watch_.look(board_, now_ns()) != GuardWatch::Action::stop) return;
    robot_.hold();
    board_.stopped = moving;
  }

  void on_tick() override { board_.tick_ns = now_ns(); }
  std::optional<Fault> fault() override {
    if (board_.stopped == activation_) return Fault{StopCause::guard_stops, 0, {}, 0.0};
    if (lives()) return std::nullopt;  // it has looked during a late tick, too
    const std::int64_t age_ns = now_ns() - board_.guard_ns;
    if (age_ns <= bound_ns) return std::nullopt;
    return Fault{StopCause::guard_lost, 0, {}, 1e-6 * static_cast<double>(age_ns)};
  }
  void activated() override {
    on_tick();
    board_.moving = ++activation_;
  }
  void released() override { board_.moving = 0; }

 private:
  static constexpr std::int64_t bound_ns = 35'000'000;  // WatchdogConfig::hang_ms

  [[nodiscard]] bool lives() { return !killed_us_ || robot_.clock().now_us() < *killed_us_; }
  [[nodiscard]] std::int64_t now_ns() { return 1000 * robot_.clock().now_us(); }

  FakeDeployed& robot_;
  std::optional<std::int64_t> killed_us_;
  GuardBoard board_{};
  GuardWatch watch_{bound_ns};
  std::uint64_t activation_ = 0;
};

/// A deployed robot with its faults.
class Trial {
 public:
  Trial(const Faults& faults, bool with_gaze, std::uint64_t number)
      : faults_(faults),
        robot_(faults.script, with_gaze),
        loop_(make_loop(robot_)),
        demand_(robot_.clock()),
        guard_(robot_, faults.guard_killed_us) {
    if (faults.disk) disk_ = std::make_unique<DiskFault>(*faults.disk, loop_, number);
    if (faults.demand) demand_.set(faults.demand->first, faults.demand->second);
    const auto motion = [this, with_gaze] {
      if (with_gaze) return LoopMotion{nullptr, std::nullopt, robot_.gaze()};
      return LoopMotion{make_gaze_controller(built_in_controllers().config(), faults_.script.limits),
                        JointLimiter(motion_limits(faults_.script.limits, {}))};
    };
    DeploySessionConfig config;
    config.overseers = {&demand_, &guard_};
    DeployObserver& observer = disk_ ? disk_->observer() : ignore_;
    session_.emplace(robot_, loop_, motion, requests_, observer, config);
  }

  TrialResult run();

 private:
  static Loop make_loop(FakeDeployed& robot) {
    std::vector<LoopDetector> detectors;
    detectors.push_back({"seer", std::make_unique<CircleSeer>()});
    return Loop(
        robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
        LoopGaze{0, std::make_unique<OpenGate>(TargetConfig{}), std::nullopt, FollowConfig{.start_s = 0.0}});
  }

  /// A millisecond: the guard's look every 2 ms, and a tick of deploy unless it is dead. False at the end of the session.
  bool step();
  void operate(std::int64_t now_us);
  /// From the stop on until it has lasted: what would be wrong.
  std::string watch_the_rest();

  const Faults& faults_;
  FakeDeployed robot_;
  Loop loop_;
  OperatorRequests requests_;
  Ignore ignore_;
  Demand demand_;
  ModelGuard guard_;
  std::unique_ptr<DiskFault> disk_;
  std::optional<DeploySession> session_;
  std::int64_t looked_us_ = INT64_MIN / 2;
  std::int64_t last_tick_us_ = 0;  // before the stop
  bool was_dead_ = false;
  bool session_goes_on_ = true;
};

void Trial::operate(std::int64_t now_us) {
  if (faults_.stop_us && now_us >= *faults_.stop_us) requests_.stop();
  if (faults_.quit_us && now_us >= *faults_.quit_us) requests_.quit(StopCause::operator_stop);
  if (faults_.insists && robot_.first_stop_us > 0 && now_us / 1000 % 20 == 0) requests_.activate();
  if (!faults_.hurries_us) return;
  if (now_us < *faults_.hurries_us && robot_.first_stop_us == 0) requests_.activate();
  if (now_us >= *faults_.hurries_us) requests_.stop();
}

bool Trial::step() {
  const std::int64_t now_us = robot_.clock().now_us();
  if (now_us - looked_us_ >= 2000) {
    looked_us_ = now_us;
    guard_.look();
  }
  if (faults_.is_dead(now_us) || !session_goes_on_) {
    was_dead_ = true;
    return robot_.clock().wait_until(now_us + 1000) == PortStatus::ok;
  }
  if (std::exchange(was_dead_, false)) {
    // After SIGCONT the reference that was on its way is sent before anything is checked.
    const HeadCommand on_its_way = robot_.world.reference_rad() + HeadCommand::Constant(0.02);
    if (robot_.is_active && robot_.gaze() == nullptr) (void)robot_.head()->command(on_its_way);
  }
  operate(now_us);
  last_tick_us_ = robot_.first_stop_us == 0 ? now_us : last_tick_us_;
  session_goes_on_ = session_->tick();
  return session_goes_on_;
}

std::string Trial::watch_the_rest() {
  const int commands = robot_.commands;
  const std::size_t targets = robot_.targets.size();
  std::int64_t until_us = robot_.first_stop_us + rest_us;
  if (faults_.halted_us) until_us = std::max(until_us, faults_.halted_us->second + rest_us);
  bool time_goes_on = session_goes_on_ || faults_.killed_us;
  while (time_goes_on && robot_.clock().now_us() < until_us) time_goes_on = step();
  if (robot_.commands != commands || robot_.targets.size() != targets) return "moved after the stop";
  if (robot_.commands_while_not_active > 0) return "a command while it was not active";
  HeadState head;
  const bool readable = !faults_.script.lost_us && !faults_.script.freeze_us && !faults_.script.nan_us;
  if (time_goes_on && readable && robot_.gaze() == nullptr) {
    robot_.head()->read(head);
    if (head.velocity_rad_s.cwiseAbs().maxCoeff() > rest_deg_s * rad_per_deg) return "not at rest";
  }
  if (robot_.is_active && !faults_.killed_us) return "not released";
  return {};
}

TrialResult Trial::run() {
  session_->set_ready();
  requests_.activate();
  // A stuck joint is a fault when it does not follow: nothing has to happen where it need not move.
  const bool alone = faults_.list.size() == 1;
  const FaultKind kind = faults_.list[0].first;
  const bool may_not_stop = alone && (kind == FaultKind::joint_stuck || kind == FaultKind::deploy_halted);
  bool goes_on = true;
  while (goes_on && robot_.first_stop_us == 0 && robot_.clock().now_us() < longest_us) goes_on = step();
  TrialResult result;
  if (robot_.first_stop_us == 0) {
    result.stops = false;
    const std::int64_t halt_us = faults_.halted_us ? faults_.halted_us->second - faults_.halted_us->first : 0;
    // A tick that was due up to a tick after SIGSTOP is late by less than the halt.
    if (!may_not_stop || halt_us > 21'000) result.problem = "no stop";
    return result;
  }
  std::int64_t first_us = faults_.stop_us.value_or(INT64_MAX);
  for (const auto& [each, at_us] : faults_.list) {
    if (is_of_disk(each) || (each == FaultKind::joint_stuck && !alone)) continue;
    first_us = std::min(first_us, at_us);
  }
  // The watch in a thread of its own (HangWatch) stops the head first if the tick comes too late.
  const std::int64_t hang_us = last_tick_us_ + std::llround((WatchdogConfig{}.hang_ms + 2.0) * 1e3);
  if (!faults_.killed_us && !faults_.halted_us)
    robot_.first_stop_us = std::min(robot_.first_stop_us, hang_us);
  result.stop_ms = std::max(0.0, 1e-3 * static_cast<double>(robot_.first_stop_us - first_us));
  result.problem = watch_the_rest();
  const std::optional<Fault>& stop = session_->last_stop();
  if (faults_.killed_us && !stop) {
    if (result.stop_ms > most_ms) result.problem = "late: stop by the guard";
    return result;
  }
  if (!stop) {
    result.problem = "no stop by deploy";
    return result;
  }
  const bool lags = stop->cause == StopCause::joint_lags;
  if (lags ? stop->amount > WatchdogConfig{}.joint_lag_ms + 2.0 : result.stop_ms > most_ms)
    result.problem = "late: " + stop->description();
  if (alone && std::ranges::count(right_causes(kind), stop->cause) == 0)
    result.problem = "wrong cause in the log: " + stop->description();
  if (disk_) {
    if (const std::string problem = disk_->problem(); !problem.empty()) result.problem = problem;
  }
  return result;
}

}  // namespace

TrialResult run_trial(const Faults& faults, bool with_gaze, std::uint64_t number) {
  return Trial(faults, with_gaze, number).run();
}

}  // namespace saccade
