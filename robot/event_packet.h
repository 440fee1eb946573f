#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// The message formats of the YARP event ports of event-driven (IIT). All are binary bottles: 32-bit little-endian
/// integers, each value preceded by a code of its type.
/// Source: core/comms.h (v2.0, v2.1), vBottle.h and vPort.h (to v1.7) of robotology/event-driven.
enum class PacketFormat {
  packet,          ///< ev::packet<AE>, v2.0 on: ("AE", duration in us, address words)
  stamped_packet,  ///< the same built with VLIB_ENABLE_TS: a time stamp before each address word
  vbottle,         ///< vBottle, to v1.7: lists of pairs of time stamp and address behind "AE"
};

/// "packet", "stamped_packet", "vbottle", in the order of PacketFormat.
[[nodiscard]] const std::vector<std::string>& packet_format_names();
[[nodiscard]] inline bool has_stamps(PacketFormat format) { return format != PacketFormat::packet; }

/// An event of a message. recording/address_event.h describes the address word.
struct WireEvent {
  std::uint32_t stamp = 0;  ///< ticks of the camera's clock, wrapping; 0 where the format has none
  std::uint32_t address = 0;

  friend bool operator==(const WireEvent&, const WireEvent&) = default;
};

/// One message. A message without events shows that the camera is connected.
struct EventPacket {
  std::int64_t duration_us =
      0;  ///< covered by the message, up to the time in its envelope; 0 with vbottle, which has none
  std::vector<WireEvent> events;
};

/// Reads a whole message into `packet` and reuses its storage. Skips lists of other types in a vBottle. Returns an empty
/// text, or the error in the message; `packet` has no events then.
[[nodiscard]] std::string_view read_packet(std::span<const std::byte> message, PacketFormat format,
                                           EventPacket& packet);

/// Writes a whole message into `message` and reuses its storage. Stamps have 31 bits. If the format has a duration, it is
/// positive.
void write_packet(const EventPacket& packet, PacketFormat format, std::vector<std::byte>& message);

}  // namespace saccade
