#include "loop/run_log.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace saccade {
namespace {

struct Rejection {
  TargetStatus status;
  std::string_view why;
};
constexpr std::array<Rejection, 6> rejections = {{{TargetStatus::not_finite, "not finite"},
                                                  {TargetStatus::bad_radius, "no sphere has that outline"},
                                                  {TargetStatus::too_near, "too near"},
                                                  {TargetStatus::behind, "behind the head"},
                                                  {TargetStatus::too_far, "too far"},
                                                  {TargetStatus::in_body, "inside the robot's body"}}};

double seconds(std::int64_t t_us) { return static_cast<double>(t_us) * 1e-6; }

}  // namespace

void RunLog::Burst::add(std::int64_t more, std::int64_t t_us) {
  if (count == 0) first_us = t_us;
  count += more;
  last_us = t_us;
}

RunLog::RunLog(Sink sink) : sink_(std::move(sink)) { static_assert(rejections.size() == rejection_count); }

void RunLog::on_tick(const Tick& tick) {
  now_us_ = tick.t_us;
  log_head(tick);
  log_hunting(tick);
  log_rejections(tick);
  log_phase(tick);
}

void RunLog::log_phase(const Tick& tick) {
  const GazePhase before = phase_;
  phase_ = tick.phase;
  if (phase_ == before) return;
  if (phase_ == GazePhase::following) {
    const Eigen::Vector3d& at = *tick.target_m;
    const bool again = was_found_;
    was_found_ = true;
    sink_(tick.t_us, fmt::format("ball found{} at ({:.3f}, {:.3f}, {:.3f}) m", again ? " again" : "", at.x(),
                                 at.y(), at.z()));
  } else if (phase_ == GazePhase::searching && was_found_) {
    sink_(tick.t_us, "the head searches");
  } else if (phase_ == GazePhase::holding || phase_ == GazePhase::resting) {
    sink_(tick.t_us, fmt::format("target lost, last seen at {:.3f} s: the head {}", seconds(tick.target_us),
                                 phase_ == GazePhase::holding ? "holds" : "returns to rest"));
  }
}

void RunLog::log_rejections(const Tick& tick) {
  const std::array<std::int64_t, rejection_count> rejected = {
      tick.rejected.not_finite, tick.rejected.bad_radius, tick.rejected.too_near,
      tick.rejected.behind,     tick.rejected.too_far,    tick.rejected.in_body};
  for (std::size_t kind = 0; kind < rejection_count; ++kind) {
    const std::int64_t more =
        rejected[kind] - rejected_[kind] + (tick.target_status == rejections[kind].status ? 1 : 0);
    if (bursts_[kind].count > 0 && tick.t_us - bursts_[kind].last_us > burst_gap_us) end_burst(kind);
    if (more > 0) bursts_[kind].add(more, tick.t_us);
  }
  rejected_ = rejected;
}

void RunLog::end_burst(std::size_t kind) {
  Burst& burst = bursts_[kind];
  if (burst.count == 0) return;
  sink_(now_us_, fmt::format("target rejected, {}: {} from {:.3f} to {:.3f} s", rejections[kind].why,
                             burst.count == 1 ? "once" : fmt::format("{} times", burst.count),
                             seconds(burst.first_us), seconds(burst.last_us)));
  burst = {};
}

void RunLog::log_head(const Tick& tick) {
  if (tick.head && !is_finite(*tick.head)) {
    if (not_finite_.count == 0) sink_(tick.t_us, "head state not finite: the head holds");
    not_finite_.add(1, tick.t_us);
  } else if (not_finite_.count > 0) {
    sink_(tick.t_us, fmt::format("head state finite again, after {} ticks", not_finite_.count));
    not_finite_ = {};
  }
  if (tick.command_rejected) {
    if (rejected_commands_.count == 0)
      sink_(tick.t_us, "command rejected by the head: its last reference holds");
    rejected_commands_.add(1, tick.t_us);
  } else if (rejected_commands_.count > 0) {
    sink_(tick.t_us,
          fmt::format("the head accepts commands again, after {} rejected", rejected_commands_.count));
    rejected_commands_ = {};
  }
}

void RunLog::log_hunting(const Tick& tick) {
  if (tick.hunting_hz == 0.0) return;
  sink_(tick.t_us, fmt::format("the head oscillates at {:.1f} Hz: time constants are {:.2g} times as long",
                               tick.hunting_hz, tick.slowdown));
}

void RunLog::finish() {
  for (std::size_t kind = 0; kind < rejection_count; ++kind) end_burst(kind);
  if (phase_ == GazePhase::searching && !was_found_) sink_(now_us_, "ball never found");
}

}  // namespace saccade
