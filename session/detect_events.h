#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/detector.h"

namespace saccade {

struct TimedEstimate {
  std::int64_t t_us = 0;
  Estimate estimate;
};

/// The observations of one detector on events in memory, as detect_recording() makes them: in ticks of 1 ms at whole
/// milliseconds from the first event on.
///
/// `events`: of one camera, sorted by time; the detector rejects and counts the others. `start_us`: ticks follow it every
/// 1 ms instead. Throws InputError for events of two cameras, for events
/// more than a day apart, and for a first one more than a day after `start_us`.
[[nodiscard]] std::vector<TimedEstimate> detect_events(Detector& detector, const Camera& camera,
                                                       std::span<const Event> events,
                                                       std::optional<std::int64_t> start_us = std::nullopt);
/// The same at given instants, which rise, as with truth that has these instants (docs/scoring.md).
[[nodiscard]] std::vector<TimedEstimate> detect_events_at(Detector& detector, const Camera& camera,
                                                          std::span<const Event> events,
                                                          std::span<const std::int64_t> instants_us);

}  // namespace saccade
