#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/time_stamp.h"

namespace saccade {

/// Instants of observation where no truth is annotated are this far apart.
inline constexpr std::int64_t observation_tick_us = 1'000;
/// An observation at an annotated instant needs an event at most this much before it (docs/scoring.md).
inline constexpr std::int64_t sparse_window_us = 10'000;

/// Calls tick(t_us, scoring) at the instants after start_us, which rise, and before each of them at the start of its
/// observation window (`scoring` false), until it returns false.
template <class OnTick>
void tick_at_annotated(std::span<const std::int64_t> instants_us, std::int64_t start_us, OnTick tick) {
  std::int64_t last_us = start_us;
  for (const std::int64_t t_us : instants_us) {
    if (t_us <= last_us) continue;
    const std::int64_t window_us = saturated_sum(t_us, -sparse_window_us);
    if (window_us > last_us && !tick(window_us, false)) return;
    if (!tick(t_us, true)) return;
    last_us = t_us;
  }
}

}  // namespace saccade
