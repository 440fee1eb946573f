#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "emulator/emulator_config.h"
#include "emulator/pixel_array.h"

namespace saccade {

/// From the comparators to time stamps: latency, a bus that takes one event after the other, and the clock's ticks.
///
/// An event that asks at t reaches the bus at t + latency_us; the bus serves in that order, each event in
/// 1 / readout_rate_hz, and its stamp is the first tick at or after its end. While readout_queue_events wait, further
/// ones are lost. Events of one pixel are at least one tick apart: the bus waits. Without a limited rate an event
/// is stamped at the first tick at or after it asks.
class Readout {
 public:
  /// `pixels`: of the whole image.
  Readout(const EmulatorConfig& config, std::size_t pixels);

  /// Takes requests in the order of time, none before those taken already; appends the events with stamps up to
  /// t_us, in the order of stamps.
  void process(std::span<const PixelEvent> requests, std::int64_t t_us, std::vector<PixelEvent>& events);
  /// Appends what is still on its way.
  void finish(std::vector<PixelEvent>& events);

  [[nodiscard]] std::int64_t dropped() const { return dropped_; }
  [[nodiscard]] std::int64_t waiting() const {
    return static_cast<std::int64_t>(stamped_.size() - released_);
  }

 private:
  void stamp(PixelEvent request);
  /// When the bus is done with a request that reaches it at t_us; none when the queue is full.
  [[nodiscard]] std::optional<std::int64_t> serve(std::int64_t t_us);
  void release(std::size_t count, std::vector<PixelEvent>& events);

  EmulatorConfig config_;
  double service_us_;
  bool transparent_;  ///< nothing to do: what comes goes
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

}  // namespace saccade
