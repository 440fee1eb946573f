#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "loop/loop.h"
#include "robot/robot.h"

namespace saccade {

/// Observers of one loop, called in the order in which they were added. They outlive it.
class TickObservers final : public LoopObserver {
 public:
  void add(LoopObserver& observer) { observers_.push_back(&observer); }
  void on_tick(const Tick& tick) override {
    for (LoopObserver* const observer : observers_) observer->on_tick(tick);
  }

 private:
  std::vector<LoopObserver*> observers_;
};

/// Runs a loop on a robot, be it simulated, recorded or real: ticks it until its end or an interrupt and passes each tick
/// to the observers. Recording, scoring, logs, progress and windows are observers.
class Session {
 public:
  /// Both outlive the session.
  Session(Robot& robot, Loop& loop) : robot_(robot), loop_(loop) {}

  /// `observer` is called after each tick, after those that were added before it. It outlives the session.
  void add_observer(LoopObserver& observer) { observers_.add(observer); }

  /// One tick at t_us, later than the one before. Returns false if no more data will come. Throws RunError if the
  /// connection to the robot is lost.
  bool tick(std::int64_t t_us);
  /// Ticks every tick_us after the robot's time up to end_us, inclusive, at whole multiples of tick_us from grid_us on (none:
  /// from the robot's time); ends earlier with the robot's data, or on interrupted(). Throws as tick() does.
  void run(std::int64_t tick_us, std::int64_t end_us = std::numeric_limits<std::int64_t>::max(),
           std::optional<std::int64_t> grid_us = std::nullopt);

  /// Seconds of the wall clock since the first tick; 0 before it.
  [[nodiscard]] double wall_s() const;

 private:
  Robot& robot_;
  Loop& loop_;
  TickObservers observers_;
  std::optional<std::chrono::steady_clock::time_point> begin_;
};

}  // namespace saccade
