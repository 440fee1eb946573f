#include "apps/deploy/deploy_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace saccade {
namespace {

constexpr std::int64_t attempt_us = 100'000;
constexpr int most_ticks_to_catch_up = 50;

/// Joints that their board holds in another mode are as good as those that follow references.
void accept_held(HeadDrives& drives) {
  std::ranges::replace(drives.joints, JointDrive::held, JointDrive::references);
}

}  // namespace

std::string_view name_of(DeployState state) {
  constexpr std::array<std::string_view, 4> names = {"unconfigured", "ready", "active", "stopped"};
  return names.at(static_cast<std::size_t>(state));
}

DeploySession::DeploySession(Robot& robot, Loop& loop, MakeMotion make_motion, OperatorRequests& requests,
                             DeployObserver& observer, const DeploySessionConfig& config)
    : robot_(robot),
      loop_(loop),
      make_motion_(std::move(make_motion)),
      requests_(requests),
      observer_(observer),
      tick_us_(config.tick_us),
      tick_late_us_(std::llround(config.watchdog.tick_late_ms * 1e3)),
      watchdog_(config.watchdog, robot.head() != nullptr ? robot.head()->limits() : JointLimits{}),
      follows_(config.watchdog.joint_lag_deg),
      overseers_(config.overseers),
      joints_follow_(config.joints_follow),
      due_us_(robot.clock().now_us()),
      last_begin_us_(due_us_) {
  SACCADE_CHECK(tick_us_ > 0);
}

void DeploySession::set_ready() {
  SACCADE_CHECK(state_ == DeployState::unconfigured);
  due_us_ = last_begin_us_ = robot_.clock().now_us();
  change(DeployState::ready, std::nullopt, 0, {});
}

/// Schedules the next tick. Returns its planned time, from which its delay counts. A tick that is behind by half a period or
/// more waits for the next instant on the grid: with real-time priority, ticks without a pause would take their processor
/// from the threads that receive events and readings, and from a robot that is simulated on the same machine.
std::int64_t DeploySession::plan_tick() {
  const std::int64_t planned_us = due_us_ + tick_us_;
  const std::int64_t behind_us = std::max<std::int64_t>(0, robot_.clock().now_us() - planned_us);
  missed_ = behind_us < tick_us_ / 2 ? 0 : (behind_us + tick_us_ - 1) / tick_us_;
  due_us_ = planned_us + missed_ * tick_us_;
  return planned_us;
}

TickFacts DeploySession::facts(std::int64_t due_us) {
  TickFacts facts{due_us, robot_.clock().now_us(), robot_.events().heard_us()};
  HeadPort* const head = robot_.head();
  if (head == nullptr) return facts;
  if (head->read(facts.head.emplace()) != PortStatus::ok) facts.head.reset();
  facts.drives = head->drives();
  if (robot_.gaze() != nullptr) accept_held(*facts.drives);  // the gaze controller chooses the modes
  facts.refused_us = refused_us_;
  follows_.add_to(facts);
  return facts;
}

void DeploySession::keep_activating(std::int64_t within_us) {
  const std::int64_t now_us = robot_.clock().now_us();
  attempts_ = Attempts{now_us, now_us + within_us, now_us};
  not_activated_.clear();
}

bool DeploySession::try_to_activate(const TickFacts& facts) {
  if (!attempts_ || facts.now_us < attempts_->next_us) return true;
  // The events that came before the first tick can make it long, and then the next one late.
  const bool in_time = has_ticked_ && facts.now_us - facts.due_us <= tick_late_us_ / 2;
  if (!in_time && facts.now_us < attempts_->until_us) return true;
  attempts_->next_us = facts.now_us + attempt_us;
  activate(facts);
  if (state_ == DeployState::active) {
    attempts_.reset();
    return true;
  }
  if (robot_.clock().now_us() < attempts_->until_us) return true;
  not_activated_ =
      fmt::format("not activated within {:.1f} s: {}",
                  1e-6 * static_cast<double>(attempts_->until_us - attempts_->from_us), not_activated_);
  return false;
}

/// The first reason to stop the active head.
std::optional<Fault> DeploySession::find_fault(const TickFacts& facts) {
  for (Overseer* const overseer : overseers_) {
    if (auto fault = overseer->fault()) {
      fault->since_us = facts.now_us - std::llround(1e3 * fault->amount);
      return fault;
    }
  }
  return watchdog_.check(facts);
}

/// The reference that the head rejected, or how well the joints follow it.
void DeploySession::note_command(const Tick& tick) {
  if (state_ != DeployState::active || robot_.gaze() != nullptr || !tick.head) return;
  if (!tick.command_rejected) {
    refused_us_.reset();
  } else if (!refused_us_) {
    refused_us_ = tick.acted_us;
  }
  if (joints_follow_)
    follows_.update(tick.t_us, tick.command.reference_rad, tick.head->t_us, tick.head->head_position_rad());
}

/// Reports an overseer that ceases, or begins again, to protect the active head.
void DeploySession::note_protection(std::int64_t now_us) {
  const bool guarded = std::ranges::all_of(overseers_, &Overseer::protects);
  if (guarded == std::exchange(guarded_, guarded)) return;
  std::string line = guarded ? "the guard watches the head again" : "warning: the head moves without a guard";
  for (Overseer* const overseer : overseers_) {
    if (std::string warning = overseer->warning(); !warning.empty()) line += "; " + warning;
  }
  observer_.on_news(now_us, line);
}

/// The loop's part of the tick that is due.
PortStatus DeploySession::run_loop(std::int64_t planned_us, std::int64_t begin_us) {
  last_.tick.reset();
  const PortStatus status = loop_.tick(due_us_, last_);
  if (last_.tick) {
    TickTiming timing;
    timing.due_us = planned_us;
    timing.begin_us = begin_us;
    timing.end_us = robot_.clock().now_us();
    if (!last_.tick->events.empty())
      timing.latency_us = last_.tick->acted_us - last_.tick->events.back().t_us;
    timing.missed = missed_;
    timing.traffic = robot_.events().traffic();
    timing.state = state_;
    timing.guarded = guarded_;
    note_command(*last_.tick);
    observer_.on_tick(*last_.tick, timing);
    last_begin_us_ = begin_us;
    has_ticked_ = true;
  }
  return status;
}

/// Ticks without motion after an activation that took a while, until they are in time again: the events that came
/// meanwhile can make a tick so long that it would stop the head. Returns false if there was nothing to do.
bool DeploySession::catch_up() {
  bool has_ticked = false;
  for (int i = 0; i < most_ticks_to_catch_up; ++i) {
    const std::int64_t behind = (robot_.clock().now_us() - due_us_) / tick_us_;
    if (behind < 1) break;
    missed_ = has_ticked ? behind - 1 : missed_ + behind;
    due_us_ += behind * tick_us_;
    has_ticked = true;
    if (run_loop(due_us_, robot_.clock().now_us()) != PortStatus::ok) break;
  }
  return has_ticked;
}

bool DeploySession::tick() {
  const std::int64_t planned_us = plan_tick();
  const PortStatus time = robot_.clock().wait_until(due_us_);
  if (time != PortStatus::ok) return end(time);
  for (Overseer* const overseer : overseers_) overseer->on_tick();
  const TickFacts facts = this->facts(planned_us);

  const OperatorRequests::Request request = requests_.request_.exchange(OperatorRequests::Request::none);
  const bool quit = requests_.quit_;
  if (state_ == DeployState::active) {
    if (const auto fault = find_fault(facts)) {
      stop(*fault);
    } else if (quit || request == OperatorRequests::Request::stop) {
      stop({quit ? requests_.quit_cause_.load() : StopCause::operator_stop, facts.now_us});
    } else {
      note_protection(facts.now_us);
    }
  } else if (request == OperatorRequests::Request::stop && attempts_) {
    attempts_.reset();
    reject("the operator requested a stop");
  } else if (request == OperatorRequests::Request::activate && !quit) {
    activate(facts);
  } else if (!quit && !try_to_activate(facts)) {
    return end(PortStatus::ended);
  }
  if (quit) return end(PortStatus::ended);
  if (std::exchange(caught_up_, false)) return true;  // this tick's part of the loop is done

  const PortStatus status = run_loop(planned_us, facts.now_us);
  for (const std::string& line : robot_.news()) observer_.on_news(facts.now_us, line);
  return status == PortStatus::lost || status == PortStatus::ended ? end(status) : true;
}

/// Stops an active head.
bool DeploySession::end(PortStatus status) {
  Fault fault{StopCause::operator_stop, robot_.clock().now_us()};
  if (status == PortStatus::lost) {
    // The last tick still had the connection, so it was lost after that tick began.
    fault = {StopCause::lost, last_begin_us_, loop_.lost().empty() ? "clock" : loop_.lost()};
  } else if (!requests_.quit_) {
    fault.cause = StopCause::ended;
  }
  if (state_ == DeployState::active || status == PortStatus::lost) stop(fault);
  return false;
}

void DeploySession::activate(const TickFacts& facts) {
  if (!make_motion_)
    return reject("there is nothing to move: gaze.detector is none, or the robot has no head");
  if (state_ == DeployState::unconfigured) return reject("not every start-up check has passed");
  for (Overseer* const overseer : overseers_) {
    if (std::string reason = overseer->why_not(); !reason.empty()) return reject(std::move(reason));
  }
  TickFacts now = facts;
  now.due_us = now.now_us;  // the head did not wait for this tick
  now.refused_us.reset();
  now.lags_since_us.reset();
  if (now.drives) accept_held(*now.drives);  // they will follow references
  if (const auto fault = watchdog_.check(now)) return reject(fault->description());
  for (Overseer* const overseer : overseers_) overseer->activating();
  try {
    robot_.activate();
  } catch (const RunError& error) {
    return reject(error.what());
  }
  caught_up_ = catch_up();
  for (Overseer* const overseer : overseers_) overseer->activated();
  not_activated_.clear();
  follows_.clear();
  refused_us_.reset();
  loop_.set_motion(make_motion_());
  std::string warning;
  for (Overseer* const overseer : overseers_) {
    if (std::string lacks = overseer->warning(); !lacks.empty())
      warning += (warning.empty() ? "" : "; ") + lacks;
  }
  guarded_ = std::ranges::all_of(overseers_, &Overseer::protects);
  change(DeployState::active, std::nullopt, 0, {}, std::move(warning));
}

/// A failed activation. Of repeated attempts each reason is reported once in a row.
void DeploySession::reject(std::string reason) {
  if (attempts_ && reason == not_activated_) return;
  not_activated_ = reason;
  change(state_, std::nullopt, 0, std::move(reason));
}

void DeploySession::stop(const Fault& fault) {
  loop_.clear_motion();
  if (GazePort* const gaze = robot_.gaze()) {
    gaze->stop();
  } else if (HeadPort* const head = robot_.head()) {
    head->stop();
  }
  const std::int64_t took_us = robot_.clock().now_us() - fault.since_us;
  for (Overseer* const overseer : overseers_) overseer->stopped();
  robot_.release();
  for (Overseer* const overseer : overseers_) overseer->released();
  last_stop_ = fault;
  change(DeployState::stopped, fault, took_us, {});
}

void DeploySession::change(DeployState state, const std::optional<Fault>& stop, std::int64_t took_us,
                           std::string rejected, std::string warning) {
  state_ = state;
  observer_.on_change(
      {robot_.clock().now_us(), state, stop, took_us, std::move(rejected), std::move(warning)});
}

}  // namespace saccade
