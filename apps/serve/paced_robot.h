#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <utility>

#include "robot/robot.h"

namespace saccade {

/// Makes a simulated robot keep time with the wall clock: its clock waits until a millisecond has passed before it
/// advances the simulation by one. Everything else passes through.
///
/// After a delay the simulation catches up by up to 20 ms. Longer delays are lost: simulated time slips against the wall
/// clock, see slipped_s().
class PacedRobot final : public Robot, public Clock {
 public:
  /// Called before a step of the simulation: by how much it begins late.
  using Begun = std::function<void(std::int64_t late_us)>;

  /// `robot` outlives it. The wall clock starts now.
  explicit PacedRobot(Robot& robot, Begun begun = {}) : robot_(robot), step_begins_(std::move(begun)) {}

  Clock& clock() override { return *this; }
  EventSource& events() override { return robot_.events(); }
  HeadPort* head() override { return robot_.head(); }
  GazePort* gaze() override { return robot_.gaze(); }

  [[nodiscard]] std::int64_t now_us() const override { return robot_.clock().now_us(); }
  PortStatus wait_until(std::int64_t t_us) override;

  /// Lets us microseconds of the wall clock pass while the simulation stands still.
  void idle(std::int64_t us);
  /// Restarts the wall clock and the statistics.
  void restart();

  /// Wall-clock time spent outside of waiting, s.
  [[nodiscard]] double busy_s() const { return std::chrono::duration<double>(busy_).count(); }
  [[nodiscard]] double slipped_s() const { return std::chrono::duration<double>(slipped_).count(); }
  /// The longest tick: time from the end of a wait to the next wait, ms.
  [[nodiscard]] double longest_ms() const {
    return std::chrono::duration<double, std::milli>(longest_).count();
  }
  /// The largest delay of a tick, ms.
  [[nodiscard]] double latest_ms() const {
    return std::chrono::duration<double, std::milli>(latest_).count();
  }

 private:
  using SteadyClock = std::chrono::steady_clock;

  Robot& robot_;
  Begun step_begins_;
  SteadyClock::time_point due_ = SteadyClock::now();
  SteadyClock::time_point begun_ = due_;
  SteadyClock::duration busy_{}, slipped_{}, latest_{}, longest_{};
  SteadyClock::duration late_{};  // of this tick
};

}  // namespace saccade
