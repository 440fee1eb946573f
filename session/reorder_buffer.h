#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "loop/loop.h"

namespace saccade {

/// How long instants wait for estimates in a run with that latency: detectors that are further behind have no
/// observation there.
[[nodiscard]] inline std::int64_t processing_us(const LatencyConfig& latency) {
  constexpr std::int64_t longest_us = 200'000;
  return latency.kind == LatencyKind::none ? 0 : latency.transport_us() + longest_us;
}

/// What the detectors observe at one instant.
struct ObservedInstant {
  std::int64_t t_us = 0;
  std::vector<std::optional<Estimate>> observations;  ///< of each detector; none: no observation
};

/// Puts observations in the order of event time: holds the newest instants of a run, one per tick, until all of their events
/// have been delivered and detectors have had time to process them. Estimates from late events are about instants before
/// their tick.
class ReorderBuffer {
 public:
  static constexpr std::int64_t all_us = std::numeric_limits<std::int64_t>::max();

  /// `processing_us`: how long after its events have been delivered an instant waits for estimates.
  explicit ReorderBuffer(std::size_t detectors, std::int64_t processing_us = 0)
      : processing_us_(processing_us), ring_(capacity + static_cast<std::size_t>(processing_us / 1000)) {
    for (ObservedInstant& instant : ring_) instant.observations.resize(detectors);
  }

  /// A tick's instant, later than the one before. A limited number of them waits: pop() after each push().
  void push(std::int64_t t_us) {
    SACCADE_CHECK(count_ < ring_.size());
    ObservedInstant& instant = at(count_++);
    instant.t_us = t_us;
    std::ranges::fill(instant.observations, std::nullopt);
  }

  /// A detector's result in the tick of the newest instant. Its late estimates replace those at their instants.
  void set(std::size_t detector, const DetectorTick& result) {
    for (const LateEstimate& late : result.late) {
      for (std::size_t i = 0; i < count_; ++i) {
        if (at(i).t_us == late.t_us) at(i).observations[detector] = late.estimate;
      }
    }
    if (result.on_time) at(count_ - 1).observations[detector] = result.estimate;
  }

  /// An observation of the newest instant by what no events feed.
  void set(std::size_t detector, const std::optional<Estimate>& seen) {
    at(count_ - 1).observations[detector] = seen;
  }

  /// Passes on the instants up to `complete_us`, and the oldest one if the queue is full; in the order of time.
  template <class OnInstant>
  void pop(std::int64_t complete_us, OnInstant on_instant) {
    while (count_ > 0 && (is_complete(at(0).t_us, complete_us) || count_ == ring_.size())) {
      on_instant(std::as_const(at(0)));
      first_ = (first_ + 1) % ring_.size();
      --count_;
    }
  }

 private:
  static constexpr std::size_t capacity = 16;  // the simulator's events are at most 5 ms late

  ObservedInstant& at(std::size_t i) { return ring_[(first_ + i) % ring_.size()]; }
  [[nodiscard]] bool is_complete(std::int64_t t_us, std::int64_t complete_us) const {
    return complete_us == all_us || t_us <= complete_us - processing_us_;
  }

  std::int64_t processing_us_;
  std::vector<ObservedInstant> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace saccade
