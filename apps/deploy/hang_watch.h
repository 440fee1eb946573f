#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "apps/deploy/deploy_session.h"

namespace saccade {

/// Stops the head when no tick begins for too long while the head is active, from a thread of its own: the tick may hang
/// in a detector, in a port or in the operating system. Robot::halt() reaches the head without the thread of the ticks.
class HangWatch final : public Overseer {
 public:
  struct Config {
    std::int64_t bound_ns = 40'000'000;         ///< without a tick the head is stopped
    std::int64_t end_after_ns = 5'000'000'000;  ///< without a tick `end` is called; 0: never
  };
  /// `robot` outlives it. `halted(age_ns)` and `end()` are called in the thread of the watch; `end` after the head was
  /// stopped and the tick still hangs, to end the program. Both may be empty.
  HangWatch(Robot& robot, const Config& config, std::function<void(std::int64_t)> halted = {},
            std::function<void()> end = {});
  HangWatch(const HangWatch&) = delete;
  HangWatch& operator=(const HangWatch&) = delete;
  ~HangWatch() override;

  void on_tick() override;
  /// tick_hangs, after the head was stopped from here.
  [[nodiscard]] std::optional<Fault> fault() override;
  void activating() override;
  void activated() override;
  void stopped() override { armed_ = false; }

 private:
  void work();

  Robot& robot_;
  Config config_;
  std::function<void(std::int64_t)> halted_;
  std::function<void()> end_;
  std::atomic<std::int64_t> tick_ns_ = 0;
  std::atomic<bool> armed_ = false;
  std::atomic<std::int64_t> fired_after_ns_ =
      0;  // age of the newest tick when the head was stopped; 0: it was not
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace saccade
