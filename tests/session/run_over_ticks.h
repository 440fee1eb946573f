#pragma once

#include <cstdint>
#include <functional>

namespace saccade {

/// Drives a fake robot for `ticks` ticks of 1 ms through the loop, with a driving and a shadow detector, the tables and
/// scores of a simulated run and its log. Tables go to files that are removed. Calls `sample` with the number of ticks done
/// every `sample_ticks`.
void run_over_ticks(std::int64_t ticks, std::int64_t sample_ticks,
                    const std::function<void(std::int64_t done)>& sample);

/// Resident memory of this process, kB, from /proc/self/status.
[[nodiscard]] std::int64_t resident_kb();

}  // namespace saccade
