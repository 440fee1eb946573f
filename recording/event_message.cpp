#include "recording/event_message.h"

#include <algorithm>
#include <array>

#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/message_cursor.h"

namespace saccade {
namespace {

constexpr std::size_t array_event_bytes = 13;
constexpr std::size_t packet_event_bytes = 8;  ///< of mono
constexpr int largest_length_px = 1 << 16;
constexpr std::int64_t ns_per_us = 1000;

/// Appends numbers and texts of a message.
class MessageBytes {
 public:
  MessageBytes(std::string& bytes, Serialisation serialisation)
      : bytes_(bytes), cdr_(serialisation == Serialisation::cdr) {
    if (cdr_) bytes_ += cdr_little;
    start_ = bytes_.size();
  }
  template <std::integral T>
  void put(T value) {
    while (cdr_ && (bytes_.size() - start_) % sizeof(T) != 0) bytes_ += '\0';
    append_little(bytes_, value);
  }
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size() + (cdr_ ? 1 : 0)));
    bytes_ += text;
    if (cdr_) bytes_ += '\0';
  }
  /// A header's sequence number, stamp and frame.
  void put_header(std::uint32_t seq, std::int64_t t_us) {
    if (!cdr_) put(seq);
    put(static_cast<std::uint32_t>(t_us / 1'000'000));
    put(static_cast<std::uint32_t>(t_us % 1'000'000 * ns_per_us));
    put_text("camera");
  }

 private:
  std::string& bytes_;
  bool cdr_;
  std::size_t start_ = 0;
};

// Definitions of the messages. A line of = separates them.
const char* const header_definition_ros1 =
    "================================================================================\n"
    "MSG: std_msgs/Header\n"
    "uint32 seq\n"
    "time stamp\n"
    "string frame_id\n";
const char* const header_definition_ros2 =
    "================================================================================\n"
    "MSG: std_msgs/Header\n"
    "builtin_interfaces/Time stamp\n"
    "string frame_id\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Time\n"
    "int32 sec\n"
    "uint32 nanosec\n";
const char* const array_members =
    "Header header\n"
    "uint32 height\n"
    "uint32 width\n"
    "Event[] events\n";
const char* const event_definition =
    "================================================================================\n"
    "MSG: dvs_msgs/Event\n"
    "uint16 x\n"
    "uint16 y\n"
    "time ts\n"
    "bool polarity\n";
const char* const packet_members =
    "Header header\n"
    "uint32 height\n"
    "uint32 width\n"
    "uint64 seq\n"
    "uint64 time_base\n"
    "string encoding\n"
    "bool is_bigendian\n"
    "uint8[] events\n";

}  // namespace

std::optional<EventMessageType> event_message_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, EventMessageType>, 4> types = {
      {{"dvs_msgs/EventArray", EventMessageType::event_array},
       {"prophesee_event_msgs/EventArray", EventMessageType::event_array},
       {"event_camera_msgs/EventPacket", EventMessageType::event_packet},
       {"event_array_msgs/EventArray", EventMessageType::event_packet}}};
  std::string plain(name);
  if (const std::size_t msg = plain.find("/msg/"); msg != std::string::npos) plain.erase(msg, 4);
  for (const auto& [known, type] : types) {
    if (plain == known) return type;
  }
  return std::nullopt;
}

std::optional<BrokenMessage> EventMessageDecoder::decode(std::string_view message,
                                                         std::vector<Event>& events) {
  if (auto broken = broken_serialisation(message, serialisation_)) return broken;
  MessageCursor cursor(message, serialisation_);
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::int64_t stamp_us = 0;
  if (!cursor.take_header(stamp_us) || !cursor.take(height) || !cursor.take(width))
    return BrokenMessage{"a message that ends inside its header", "a whole message"};
  if (height > 0 && width > 0 && height <= largest_length_px && width <= largest_length_px)
    image_size_ = ImageSize{static_cast<int>(width), static_cast<int>(height)};
  return type_ == EventMessageType::event_array ? decode_array(cursor, events)
                                                : decode_packet(cursor, events);
}

std::optional<BrokenMessage> EventMessageDecoder::decode_array(MessageCursor& cursor,
                                                               std::vector<Event>& events) const {
  std::uint32_t count = 0;
  if (!cursor.take(count)) return BrokenMessage{"a message that ends before its events", "a whole message"};
  const bool cdr = serialisation_ == Serialisation::cdr;
  const std::size_t there = cursor.rest().size() / array_event_bytes;
  if (!cdr) events.reserve(events.size() + std::min<std::size_t>(count, there));
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint16_t x = 0;
    std::uint16_t y = 0;
    std::uint32_t seconds = 0;
    std::uint32_t ns = 0;
    std::uint8_t polarity = 0;
    if (!cursor.take(x) || !cursor.take(y) || !cursor.take(seconds) || !cursor.take(ns) ||
        !cursor.take(polarity))
      return BrokenMessage{
          "a message that ends after " + std::to_string(i) + " of " + std::to_string(count) + " events",
          "a whole message"};
    events.push_back({seconds * std::int64_t{1'000'000} + us_of(ns), x, y, polarity != 0, 0});
  }
  return std::nullopt;
}

std::optional<BrokenMessage> EventMessageDecoder::decode_packet(MessageCursor& cursor,
                                                                std::vector<Event>& events) {
  std::uint64_t seq = 0;
  std::uint64_t time_base_ns = 0;
  std::string_view encoding;
  std::uint8_t big_endian = 0;
  if (!cursor.take(seq) || !cursor.take(time_base_ns) || !cursor.take_text(encoding) ||
      !cursor.take(big_endian))
    return BrokenMessage{"a message that ends before its events", "a whole message"};
  encoding_ = printable(encoding);
  if (big_endian != 0) return BrokenMessage{"a packet of a big-endian machine", "little-endian events"};
  std::uint32_t size = 0;
  if (!cursor.take(size)) return BrokenMessage{"a message that ends before its events", "a whole message"};
  const std::string_view bytes = cursor.rest().substr(0, size);
  std::optional<BrokenMessage> broken = packets_.decode(encoding, time_base_ns, bytes, events);
  if (!broken && bytes.size() != size)
    return BrokenMessage{"a packet that ends inside its events", "a whole packet"};
  return broken;
}

void append_event_array(std::string& bytes, std::span<const Event> events, ImageSize image,
                        std::uint32_t seq) {
  MessageBytes message(bytes, Serialisation::ros1);
  message.put_header(seq, events.front().t_us);
  message.put(static_cast<std::uint32_t>(image.height));
  message.put(static_cast<std::uint32_t>(image.width));
  message.put(static_cast<std::uint32_t>(events.size()));
  bytes.reserve(bytes.size() + events.size() * array_event_bytes);
  for (const Event& event : events) {
    message.put(event.x);
    message.put(event.y);
    message.put(static_cast<std::uint32_t>(event.t_us / 1'000'000));
    message.put(static_cast<std::uint32_t>(event.t_us % 1'000'000 * ns_per_us));
    message.put(static_cast<std::uint8_t>(event.on));
  }
}

void append_event_packet(std::string& bytes, std::span<const Event> events, ImageSize image,
                         std::uint32_t seq, Serialisation serialisation) {
  const std::int64_t base_us = events.front().t_us;
  MessageBytes message(bytes, serialisation);
  message.put_header(seq, base_us);
  message.put(static_cast<std::uint32_t>(image.height));
  message.put(static_cast<std::uint32_t>(image.width));
  message.put(std::uint64_t{seq});
  message.put(static_cast<std::uint64_t>(base_us * ns_per_us));
  message.put_text("mono");
  message.put(std::uint8_t{0});
  message.put(static_cast<std::uint32_t>(events.size() * packet_event_bytes));
  bytes.reserve(bytes.size() + events.size() * packet_event_bytes);
  for (const Event& event : events) {
    const auto after_ns = static_cast<std::uint64_t>((event.t_us - base_us) * ns_per_us);
    append_little(bytes, static_cast<std::uint64_t>(event.on) << 63 | std::uint64_t{event.y} << 48 |
                             std::uint64_t{event.x} << 32 | after_ns);
  }
}

std::string event_array_definition() {
  std::string text = array_members;
  text += header_definition_ros1;
  text += event_definition;
  return text;
}

std::string event_packet_definition(Serialisation serialisation) {
  const bool cdr = serialisation == Serialisation::cdr;
  std::string text = cdr ? "std_msgs/" : "";
  text += packet_members;
  text += cdr ? header_definition_ros2 : header_definition_ros1;
  return text;
}

}  // namespace saccade
