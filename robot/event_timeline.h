#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/event.h"
#include "recording/address_event.h"
#include "robot/event_packet.h"
#include "robot/sender_clock.h"

namespace saccade {

/// What the events of one port are.
struct EventTimelineConfig {
  ImageSize image_size;  ///< after the axes were turned
  AddressCodec codec = AddressCodec::ev2;
  PacketFormat format = PacketFormat::packet;
  int stamp_bits = 30;  ///< 24 to 32; looked at where the format has stamps
  bool swap_xy = false;
  bool flip_x = false;  ///< after swap_xy
  bool flip_y = false;
  std::optional<std::uint8_t> camera;       ///< of all events; else each word's own channel
  std::int64_t longest_spread_us = 10'000;  ///< > 0
};

/// Lets stamps go forward only: an event a little behind the newest one gets its time.
class ForwardOnly {
 public:
  /// False, and the event is to be dropped, where it is more than `latest_us` behind.
  bool admit(Event& event) {
    if (event.t_us < newest_us_ - latest_us) return false;
    if (event.t_us < newest_us_) event.t_us = newest_us_;
    newest_us_ = event.t_us;
    return true;
  }
  static constexpr std::int64_t latest_us = 5'000;

 private:
  std::int64_t newest_us_ = INT64_MIN / 2;
};

/// Makes events of the messages of one port: pixel and polarity as here, times on the receiver's clock, sorted, never
/// later than the message came.
///
/// Without stamps in the message its events are spread evenly over its duration, up to the time in its envelope (where
/// it has none, up to its arrival), but over the last `longest_spread_us` at most: a camera that was still for long
/// says so with a long duration, and what ended the silence came last. With stamps the newest is taken to be the
/// message's time, and the others keep their distance from it.
class EventTimeline {
 public:
  explicit EventTimeline(const EventTimelineConfig& config);

  /// Appends the events of a message that came at `arrival_us` (never goes back) and says it was sent at `sent_us` on
  /// the sender's clock.
  void add(const EventPacket& packet, std::optional<std::int64_t> sent_us, std::int64_t arrival_us,
           std::vector<Event>& events);
  /// The sender is another one from now on: its clocks are unknown.
  void restart();

  /// Events left out so far: outside the image, touches of the skin, or more than 5 ms behind those before.
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }

 private:
  void take(const WireEvent& wire, std::int64_t t_us, std::vector<Event>& events);
  void add_spread(const EventPacket& packet, std::int64_t end_us, std::vector<Event>& events);
  void add_stamped(const EventPacket& packet, std::int64_t arrival_us, std::vector<Event>& events);

  EventTimelineConfig config_;
  SenderClock sender_;
  StampCounter counter_;
  ForwardOnly forward_;
  std::optional<std::int64_t> last_arrival_us_;
  std::int64_t dropped_ = 0;
};

}  // namespace saccade
