#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "recording/event_packet.h"
#include "recording/message_cursor.h"

namespace saccade {

/// ROS messages that hold events (github.com/uzh-rpg/rpg_dvs_ros, github.com/ros-event-camera/event_camera_msgs).
enum class EventMessageType {
  event_array,  ///< header, height, width, then events of u16 x, u16 y, time ts, bool polarity (1 is ON)
  event_packet,  ///< header, height, width, u64 seq, u64 time_base (ns), text encoding, bool is_bigendian, bytes events
};

/// The message of a ROS 1 or ROS 2 type's name: `dvs_msgs/EventArray` and the layout's other name
/// `prophesee_event_msgs/EventArray`; `event_camera_msgs/EventPacket` and its older name `event_array_msgs/EventArray`;
/// with `/msg/` too. None for other types.
[[nodiscard]] std::optional<EventMessageType> event_message_type(std::string_view name);

/// The messages of one topic as events.
class EventMessageDecoder {
 public:
  /// Triggers go to `others` (null: are skipped) with the topic's name.
  EventMessageDecoder(EventMessageType type, Serialisation serialisation, OtherRecords* others = nullptr,
                      const std::string& topic = "")
      : type_(type), serialisation_(serialisation) {
    packets_.pass_triggers_to(others, topic);
  }

  /// Appends the events of the next message. Where the message is broken, the events before that place are appended.
  ///
  /// Times are in us. EventArray: the events' own, to the nearest us. EventPacket: recording/event_packet.h.
  [[nodiscard]] std::optional<BrokenMessage> decode(std::string_view message, std::vector<Event>& events);

  /// Of the last message that has one.
  [[nodiscard]] std::optional<ImageSize> image_size() const { return image_size_; }
  /// Of the last EventPacket; empty before.
  [[nodiscard]] const std::string& encoding() const { return encoding_; }
  /// Counts what a sensor's words hold besides events.
  [[nodiscard]] const PacketDecoder& packets() const { return packets_; }

 private:
  std::optional<BrokenMessage> decode_array(MessageCursor& cursor, std::vector<Event>& events) const;
  std::optional<BrokenMessage> decode_packet(MessageCursor& cursor, std::vector<Event>& events);

  EventMessageType type_;
  Serialisation serialisation_;
  std::optional<ImageSize> image_size_;
  std::string encoding_;
  PacketDecoder packets_;
};

/// Appends an EventArray of at least one event in ROS 1's serialisation. `seq`: number of the message.
void append_event_array(std::string& bytes, std::span<const Event> events, ImageSize image,
                        std::uint32_t seq);
/// Appends an EventPacket of encoding mono. Events are at most 2^32 ns later than the first one, which is the earliest; y is below
/// 2^15.
void append_event_packet(std::string& bytes, std::span<const Event> events, ImageSize image,
                         std::uint32_t seq, Serialisation serialisation);

/// The definitions of the messages, as bags and MCAP files contain them, and the MD5 sums by which ROS 1 compares them.
[[nodiscard]] std::string event_array_definition();
[[nodiscard]] std::string event_packet_definition(Serialisation serialisation);
inline constexpr std::string_view event_array_md5 = "5e8beee5a6c107e504c2e78903c224b8";
inline constexpr std::string_view event_packet_md5 = "8a6101b351a64529ac77bd8b71074e52";

}  // namespace saccade
