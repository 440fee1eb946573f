#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "emulator/emulator_config.h"
#include "emulator/pixel_array.h"

namespace saccade::inline v0_1 {

/// The readout from comparators to time stamps: latency, a bus that transmits one event after the other, and the ticks of the
/// clock.
///
/// An event of time t reaches the bus at t + latency_us. The bus transmits events in that order, each in
/// 1 / readout_rate_hz, and the stamp is the first tick at or after the end of the transmission. While
/// readout_queue_events are waiting, further events are dropped. Events of one pixel are at least one tick apart: the bus
/// waits. Without a limited rate the stamp is the first tick at or after t + latency_us.
class Readout {
 public:
  /// `pixels`: number of pixels of the whole image.
  Readout(const EmulatorConfig& config, std::size_t pixels);

  /// Takes events in the order of time, after those of previous calls; appends the events with stamps up to t_us, in the
  /// order of stamps.
  void process(std::span<const PixelEvent> requests, std::int64_t t_us, std::vector<PixelEvent>& events);
  /// Appends the events that are still delayed.
  void finish(std::vector<PixelEvent>& events);

  [[nodiscard]] std::int64_t dropped() const { return dropped_; }
  [[nodiscard]] std::int64_t waiting() const {
    return static_cast<std::int64_t>(stamped_.size() - released_);
  }

 private:
  void stamp(PixelEvent request);
  /// End of the transmission of an event that reaches the bus at t_us; none if the queue is full.
  [[nodiscard]] std::optional<std::int64_t> serve(std::int64_t t_us);
  void release(std::size_t count, std::vector<PixelEvent>& events);

  EmulatorConfig config_;
  double service_us_;
  bool transparent_;  ///< no latency, rate or resolution: events pass unchanged
  std::vector<std::int64_t>
      last_stamp_us_;                ///< of each pixel; empty where no two of its events can share a tick
  std::vector<PixelEvent> stamped_;  ///< in the order of stamps; the first `released_` are gone
  std::size_t released_ = 0;
  std::vector<std::int64_t> departures_us_;  ///< of what the bus has taken; the first `departed_` are over
  std::size_t departed_ = 0;
  // A busy period of the bus: its start, and the events served since.
  std::int64_t busy_since_us_;
  std::int64_t busy_events_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace saccade::inline v0_1
