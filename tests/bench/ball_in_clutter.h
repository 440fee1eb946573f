#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/event.h"
#include "core/random.h"

namespace saccade {

/// Events of 128 x 128 pixels: six of ten on the outline of a ball that goes round in the image, the others anywhere.
inline std::vector<Event> ball_in_clutter(std::int64_t events_per_ms, std::int64_t duration_ms) {
  const RandomStream random(1, "ball_in_clutter");
  const auto count = static_cast<std::uint64_t>(events_per_ms * duration_ms);
  std::vector<Event> events;
  events.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::int64_t t_us = static_cast<std::int64_t>(i) * 1000 / events_per_ms;
    const double turn = 2.0 * std::numbers::pi * 0.2e-6 * static_cast<double>(t_us);
    double x = random.uniform(0.0, 127.0, 0, i);
    double y = random.uniform(0.0, 127.0, 1, i);
    if (i % 5 < 3) {
      const double around = random.uniform(0.0, 2.0 * std::numbers::pi, 2, i);
      x = 64.0 + 20.0 * std::cos(turn) + 11.0 * std::cos(around);
      y = 64.0 + 20.0 * std::sin(turn) + 11.0 * std::sin(around);
    }
    events.push_back({t_us + 1, static_cast<std::uint16_t>(std::lround(x)),
                      static_cast<std::uint16_t>(std::lround(y)), i % 2 == 0, 0});
  }
  return events;
}

}  // namespace saccade
