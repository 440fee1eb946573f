#include "apps/deploy/deploy_session.h"

#include <algorithm>
#include <array>

#include "core/error.h"

namespace saccade {

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
      watchdog_(config.watchdog, robot.head() != nullptr ? robot.head()->limits() : JointLimits{}),
      due_us_(robot.clock().now_us()),
      last_begin_us_(due_us_) {
  SACCADE_CHECK(tick_us_ > 0);
}

void DeploySession::set_ready() {
  SACCADE_CHECK(state_ == DeployState::unconfigured);
  due_us_ = last_begin_us_ = robot_.clock().now_us();
  change(DeployState::ready, std::nullopt, 0, {});
}

/// Schedules the next tick. Returns its planned time, from which its delay counts.
std::int64_t DeploySession::plan_tick() {
  const std::int64_t planned_us = due_us_ + tick_us_;
  missed_ = std::max<std::int64_t>(0, (robot_.clock().now_us() - planned_us) / tick_us_);
  due_us_ = planned_us + missed_ * tick_us_;
  return planned_us;
}

TickFacts DeploySession::facts(std::int64_t due_us) {
  TickFacts facts{due_us, robot_.clock().now_us(), robot_.events().heard_us()};
  HeadPort* const head = robot_.head();
  if (head != nullptr && head->read(facts.head.emplace()) != PortStatus::ok) facts.head.reset();
  return facts;
}

bool DeploySession::tick() {
  const std::int64_t planned_us = plan_tick();
  const PortStatus time = robot_.clock().wait_until(due_us_);
  if (time != PortStatus::ok) return end(time);
  const TickFacts facts = this->facts(planned_us);

  const OperatorRequests::Request request = requests_.request_.exchange(OperatorRequests::Request::none);
  const bool quit = requests_.quit_;
  if (state_ == DeployState::active) {
    if (const auto fault = watchdog_.check(facts)) {
      stop(*fault);
    } else if (quit || request == OperatorRequests::Request::stop) {
      stop({quit ? requests_.quit_cause_.load() : StopCause::operator_stop, facts.now_us});
    }
  } else if (request == OperatorRequests::Request::activate && !quit) {
    activate(facts);
  }
  if (quit) return end(PortStatus::ended);

  last_.tick.reset();
  const PortStatus status = loop_.tick(due_us_, last_);
  if (last_.tick) {
    TickTiming timing;
    timing.due_us = planned_us;
    timing.begin_us = facts.now_us;
    timing.end_us = robot_.clock().now_us();
    if (!last_.tick->events.empty())
      timing.latency_us = last_.tick->acted_us - last_.tick->events.back().t_us;
    timing.missed = missed_;
    timing.traffic = robot_.events().traffic();
    timing.state = state_;
    observer_.on_tick(*last_.tick, timing);
    last_begin_us_ = facts.now_us;
  }
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
    return change(state_, std::nullopt, 0,
                  "there is nothing to move: gaze.detector is none, or the robot has no head");
  if (state_ == DeployState::unconfigured)
    return change(state_, std::nullopt, 0, "not every start-up check has passed");
  TickFacts now = facts;
  now.due_us = now.now_us;  // the head did not wait for this tick
  if (const auto fault = watchdog_.check(now)) return change(state_, std::nullopt, 0, fault->description());
  try {
    robot_.activate();
  } catch (const RunError& error) {
    return change(state_, std::nullopt, 0, error.what());
  }
  loop_.set_motion(make_motion_());
  due_us_ += (robot_.clock().now_us() - due_us_) / tick_us_ * tick_us_;  // it may have taken a while
  change(DeployState::active, std::nullopt, 0, {});
}

void DeploySession::stop(const Fault& fault) {
  loop_.clear_motion();
  if (GazePort* const gaze = robot_.gaze()) {
    gaze->stop();
  } else if (HeadPort* const head = robot_.head()) {
    head->stop();
  }
  const std::int64_t took_us = robot_.clock().now_us() - fault.since_us;
  robot_.release();
  last_stop_ = fault;
  change(DeployState::stopped, fault, took_us, {});
}

void DeploySession::change(DeployState state, const std::optional<Fault>& stop, std::int64_t took_us,
                           std::string rejected) {
  state_ = state;
  observer_.on_change({robot_.clock().now_us(), state, stop, took_us, std::move(rejected)});
}

}  // namespace saccade
