#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/random.h"
#include "emulator/emulator_config.h"
#include "emulator/pixel_array.h"
#include "threads/large_vector.h"

namespace saccade {

/// The readout from comparators to time stamps: latency, a bus that transmits one event after the other, and the ticks of the
/// clock.
///
/// An event of time t reaches the bus at t + latency_us. The bus transmits events in that order, each in
/// 1 / readout_rate_hz, and the stamp is the first tick at or after the end of the transmission. While
/// readout_queue_events are waiting, further events are dropped. Events of one pixel are at least one tick apart: the bus
/// waits. Without a limited rate the stamp is the first tick at or after t + latency_us.
///
/// Arbitration is fair: events that reach the bus in the same microsecond are transmitted in a random order, so that no
/// row, column or polarity is preferred when events wait or are dropped. The order depends on the seed and on the time
/// since the first event alone. Where all of them get the same stamp, it is that of the input.
class Readout {
 public:
  /// `pixels`: number of pixels of the whole image.
  Readout(const EmulatorConfig& config, std::size_t pixels, std::uint64_t seed);

  /// Takes events in the order of time, after those of previous calls, with all events of a microsecond in one call;
  /// appends the events with stamps up to t_us, in the order of stamps.
  void process(std::span<const PixelEvent> requests, std::int64_t t_us, std::vector<PixelEvent>& events);
  /// Appends the events that are still delayed.
  void finish(std::vector<PixelEvent>& events);

  [[nodiscard]] std::int64_t dropped() const { return dropped_; }
  [[nodiscard]] std::int64_t waiting() const {
    return static_cast<std::int64_t>(stamped_.size() - released_);
  }

 private:
  /// Whether the order of the next `count` events, which reach the bus together, decides on stamps or on what is dropped.
  [[nodiscard]] bool order_matters(std::size_t count) const;
  void stamp(PixelEvent request);
  /// Removes what the bus has transmitted by t_us from the queue. A queue that is empty then begins a busy period at t_us.
  void advance_bus(std::int64_t t_us);
  [[nodiscard]] std::int64_t in_queue() const {
    return static_cast<std::int64_t>(departures_us_.size() - departed_);
  }
  /// End of the transmission of the `count`-th further event of the busy period.
  [[nodiscard]] std::int64_t transmitted_us(std::int64_t count) const;
  /// End of the transmission of an event that reaches the bus at t_us; none if the queue is full.
  [[nodiscard]] std::optional<std::int64_t> serve(std::int64_t t_us);
  void release(std::size_t count, std::vector<PixelEvent>& events);

  EmulatorConfig config_;
  RandomStream random_;
  std::optional<std::int64_t>
      origin_us_;  ///< time of the first request, so that random numbers follow a shift of time
  double service_us_;
  bool transparent_;  ///< no latency, rate or resolution: events pass unchanged
  LargeVector<std::int64_t>
      last_stamp_us_;                 ///< of each pixel; empty where no two of its events can share a tick
  std::vector<PixelEvent> shuffled_;  ///< the events of one microsecond in the order of transmission
  std::vector<PixelEvent> stamped_;   ///< in the order of stamps; the first `released_` are gone
  std::size_t released_ = 0;
  std::vector<std::int64_t> departures_us_;  ///< of what the bus has taken; the first `departed_` are over
  std::size_t departed_ = 0;
  // A busy period of the bus: its start, and the events served since.
  std::int64_t busy_since_us_;
  std::int64_t busy_events_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace saccade
