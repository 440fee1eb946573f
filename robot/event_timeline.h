#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/event.h"
#include "recording/address_event.h"
#include "robot/event_packet.h"
#include "robot/sender_clock.h"

namespace saccade {

/// The format of the events of one port.
struct EventTimelineConfig {
  ImageSize image_size;  ///< after swap_xy
  AddressCodec codec = AddressCodec::ev2;
  PacketFormat format = PacketFormat::packet;
  int stamp_bits = 30;  ///< 24 to 32; used if the format has stamps
  bool swap_xy = false;
  bool flip_x = false;  ///< after swap_xy
  bool flip_y = false;
  bool swap_polarity = false;               ///< the polarity bit 1 means brighter; else darker (AddressCodec)
  std::optional<std::uint8_t> camera;       ///< of all events; none: the channel in each address word
  std::int64_t longest_spread_us = 10'000;  ///< > 0
};

/// What the events of a port show of its camera, to check a configuration by.
struct CameraView {
  std::int64_t events = 0;   ///< decoded, before they are checked
  std::int64_t outside = 0;  ///< of them outside the configured image
  std::int64_t on = 0;       ///< of them with polarity ON
  int max_x = 0, max_y = 0;  ///< after swap_xy; flips have no effect

  /// Compares them with the configuration: the events of an image of another size, or words of another codec, lie
  /// outside it or in a part of it, and have one polarity. Says nothing before 1000 events. Returns what is wrong, empty
  /// if nothing.
  [[nodiscard]] std::string problem(ImageSize configured) const;
};

/// Makes time stamps non-decreasing: an event up to 5 ms behind the newest one gets the newest time stamp.
class ForwardOnly {
 public:
  /// Returns false if the event is more than `latest_us` behind the newest one and must be dropped.
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

/// Converts the messages of one port to events: pixel and polarity as in Event, time stamps on the clock of the receiver,
/// sorted, and not later than the arrival of the message.
///
/// Without stamps in the message its events are spread evenly over its duration, which ends at the time in its envelope
/// (without one: at its arrival), but over the last `longest_spread_us` at most: after a pause the duration is long, and
/// its events are at its end. With stamps the newest stamp is the time of the message; the others keep their distance
/// from it.
class EventTimeline {
 public:
  explicit EventTimeline(const EventTimelineConfig& config);

  /// Appends the events of a message that arrived at `arrival_us` (never decreases) and was sent at `sent_us` on the clock
  /// of the sender.
  void add(const EventPacket& packet, std::optional<std::int64_t> sent_us, std::int64_t arrival_us,
           std::vector<Event>& events);
  /// Resets the clocks, for a new sender.
  void restart();

  /// Events dropped so far: outside the image, from the skin sensors, or more than 5 ms behind earlier ones.
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }
  [[nodiscard]] const CameraView& view() const { return view_; }

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
  CameraView view_;
};

}  // namespace saccade
