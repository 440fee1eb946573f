#pragma once

#include <chrono>
#include <cstdint>
#include <thread>

#include "robot/ports.h"

namespace saccade {

/// The steady clock of the machine, 0 at construction.
class SteadyClock final : public Clock {
 public:
  [[nodiscard]] std::int64_t now_us() const override {
    return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - start_)
        .count();
  }
  PortStatus wait_until(std::int64_t t_us) override {
    std::this_thread::sleep_until(start_ + std::chrono::microseconds(t_us));
    return PortStatus::ok;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace saccade
