#pragma once

#include <chrono>

namespace saccade {

using WallClock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_between(WallClock::time_point from, WallClock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace saccade
