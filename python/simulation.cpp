#include "python/simulation.h"

#include <cmath>
#include <utility>

#include "core/error.h"
#include "session/scenario_loop.h"

namespace saccade::python {
namespace {

/// One of its own detectors and gaze, or one that only passes time.
Loop loop_of(const Scenario& scenario, SimRobot& robot, bool closed_loop) {
  return closed_loop ? make_loop(scenario, robot) : make_loop(scenario, robot, {}, std::nullopt);
}

constexpr double tick_s = 1e-6 * static_cast<double>(World::tick_us);

void require(PortStatus status) {
  if (status != PortStatus::ok) throw RunError("the simulated world has ended");
}

}  // namespace

Simulation::Simulation(Scenario scenario, bool closed_loop, std::shared_ptr<ObjectErrors> errors)
    : scenario_(std::move(scenario)),
      errors_(std::move(errors)),
      robot_(scenario_.sim, static_cast<std::uint64_t>(scenario_.seed)),
      loop_(loop_of(scenario_, robot_, closed_loop)),
      closed_loop_(closed_loop),
      observations_(loop_),
      moves_head_(closed_loop && make_gaze(scenario_, robot_.limits()).has_value()) {
  require(robot_.read(head_));
}

void Simulation::refuse_in_closed_loop(const char* what) const {
  if (closed_loop_)
    throw InputError("action", what, "None, because closed_loop=True lets the scenario's gaze move the head");
}

bool Simulation::command(const HeadCommand& reference_rad) {
  refuse_in_closed_loop("joint references");
  const HeadPort::CommandResult result = robot_.command(reference_rad);
  require(result.status);
  if (result.rejected) return false;
  following_ = false;
  reference_rad_ = reference_rad;
  return true;
}

TargetStatus Simulation::look_at(const Eigen::Vector3d& target_m) {
  refuse_in_closed_loop("a gaze target");
  const GazeControllerConfig& config = scenario_.gaze.controller;
  if (!config.follows_targets())
    throw InputError("gaze.controller", config.controller,
                     "a controller that follows targets, for a gaze target");
  const TargetStatus status =
      check_gaze_target(target_m, HeadKinematics(robot_.limits().head->chain, head_.position_rad));
  if (status != TargetStatus::ok) return status;
  if (!following_) {
    controller_ = make_gaze_controller(config, aiming_limits(scenario_, robot_.limits()));
    limiter_.emplace(motion_limits(robot_.limits(), config.limits));
    following_ = true;
  }
  new_target_m_ = target_m;
  target_m_ = target_m;
  return status;
}

void Simulation::step_controller() {
  const HeadCommand wanted_rad = controller_->step(head_, std::exchange(new_target_m_, std::nullopt), tick_s);
  const JointLimiter::Result limited = limiter_->apply(wanted_rad, head_.head_position_rad(), tick_s);
  const HeadPort::CommandResult result = robot_.command(limited.reference_rad);
  require(result.status);
  if (!result.rejected) reference_rad_ = limited.reference_rad;
}

void Simulation::step(std::int64_t ticks) {
  events_.clear();
  const std::int64_t end_us = std::llround(scenario_.run.duration_s * 1e6);
  for (; ticks > 0 && robot_.now_us() < end_us; --ticks) tick();
  if (errors_) errors_->rethrow();
}

void Simulation::tick() {
  if (following_) step_controller();
  require(loop_.tick(robot_.now_us() + World::tick_us, *this));
}

void Simulation::on_tick(const Tick& tick) {
  events_.insert(events_.end(), tick.events.begin(), tick.events.end());
  if (tick.head) head_ = *tick.head;
  if (!closed_loop_) return;
  if (moves_head_ && !tick.command_rejected) reference_rad_ = tick.command.reference_rad;
  target_m_ = tick.target_m;
  observations_.on_tick(tick);
  detectors_.clear();
  const ObservedInstant& instant = observations_.completed().front();
  for (std::size_t i = 0; i < loop_.detectors().size(); ++i)
    detectors_.emplace_back(loop_.detectors()[i].name, instant.observations[i].value_or(Estimate{}));
}

}  // namespace saccade::python
