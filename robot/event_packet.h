#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// What a message of one of event-driven's (IIT) YARP ports looks like. All of them are binary bottles: 32-bit
/// little-endian integers, each value behind a code of its type.
/// Source: core/comms.h (v2.0, v2.1), vBottle.h and vPort.h (to v1.7) of robotology/event-driven.
enum class PacketFormat {
  packet,          ///< ev::packet<AE>, v2.0 on: ("AE", duration in us, address words)
  stamped_packet,  ///< the same built with VLIB_ENABLE_TS: a time stamp before each address word
  vbottle,         ///< vBottle, to v1.7: lists of pairs of time stamp and address behind "AE"
};

/// "packet", "stamped_packet", "vbottle", in the order of PacketFormat.
[[nodiscard]] const std::vector<std::string>& packet_format_names();
[[nodiscard]] inline bool has_stamps(PacketFormat format) { return format != PacketFormat::packet; }

/// An event as it is on the wire. What the address word holds tells recording/address_event.h.
struct WireEvent {
  std::uint32_t stamp = 0;  ///< ticks of the camera's clock, wrapping; 0 where the format has none
  std::uint32_t address = 0;

  friend bool operator==(const WireEvent&, const WireEvent&) = default;
};

/// One message. It may be without events: a camera that sees nothing is still heard.
struct EventPacket {
  std::int64_t duration_us =
      0;  ///< that it covers, up to its envelope's time; 0 with vbottle, which has none
  std::vector<WireEvent> events;
};

/// Reads a whole message into `packet`, whose storage is used again. Lists of other types in a vBottle are passed
/// over. Returns what is wrong with the message; empty where it is right. `packet` has no events where it is not.
[[nodiscard]] std::string_view read_packet(std::span<const std::byte> message, PacketFormat format,
                                           EventPacket& packet);

/// Writes a whole message into `message`, whose storage is used again. Stamps need 31 bits; a duration has to be
/// positive where the format has one.
void write_packet(const EventPacket& packet, PacketFormat format, std::vector<std::byte>& message);

}  // namespace saccade
