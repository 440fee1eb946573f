#include "robot/event_packet.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "robot/bottle.h"

namespace saccade {
namespace {

using bottle::tag_int32;
using bottle::tag_list;
using bottle::tag_string;
using Reader = bottle::Reader;

constexpr std::string_view vision_type = "AE";

bool is_text(std::span<const std::byte> bytes, std::string_view text) {
  return bytes.size() == text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
}

/// Appends events that lie there as structs.
void append(std::span<const std::byte> bytes, bool stamped, std::vector<WireEvent>& events) {
  const std::size_t words = stamped ? 2 : 1;
  const std::size_t count = bytes.size() / (4 * words);
  const std::size_t first = events.size();
  events.resize(first + count);
  if (stamped) {
    static_assert(sizeof(WireEvent) == 8);
    if (count > 0) std::memcpy(events.data() + first, bytes.data(), count * sizeof(WireEvent));
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(&events[first + i].address, bytes.data() + 4 * i, 4);
  }
}

std::string_view read_ev_packet(Reader& reader, std::int32_t count, bool stamped, EventPacket& packet) {
  std::span<const std::byte> type;
  std::int32_t duration_us = 0;
  std::span<const std::byte> structs;
  if (count != 3) return "not an ev::packet: it has not three parts";
  if (!reader.is(tag_string) || !reader.sized_block(type)) return "not an ev::packet: it has no type";
  if (!is_text(type, vision_type)) return "an ev::packet of other things than AE";
  if (!reader.is(tag_int32) || !reader.integer(duration_us)) return "an ev::packet without a duration";
  if (duration_us < 0) return "an ev::packet with a negative duration";
  if (!reader.is(tag_string) || !reader.sized_block(structs)) return "an ev::packet cut short";
  if (structs.size() % (stamped ? 8 : 4) != 0) return "an ev::packet that ends inside an event";
  packet.duration_us = duration_us;
  append(structs, stamped, packet.events);
  return {};
}

/// A list of integers, written with one type for all of them or one for each.
bool read_integers(Reader& reader, std::int32_t code, std::vector<WireEvent>& events) {
  std::int32_t count = 0;
  if ((code != tag_list && code != (tag_list | tag_int32)) || !reader.integer(count)) return false;
  if (count < 0 || count % 2 != 0) return false;
  if (code == (tag_list | tag_int32)) {
    std::span<const std::byte> structs;
    if (!reader.block(4 * static_cast<std::size_t>(count), structs)) return false;
    append(structs, true, events);
    return true;
  }
  for (std::int32_t i = 0; i < count; i += 2) {
    std::int32_t stamp = 0;
    std::int32_t address = 0;
    if (!reader.is(tag_int32) || !reader.integer(stamp) || !reader.is(tag_int32) ||
        !reader.integer(address)) {
      return false;
    }
    events.push_back({static_cast<std::uint32_t>(stamp), static_cast<std::uint32_t>(address)});
  }
  return true;
}

std::string_view read_vbottle(Reader& reader, std::int32_t count, EventPacket& packet) {
  if (count % 2 != 0) return "not a vBottle: a type without its list";
  for (std::int32_t i = 0; i < count; i += 2) {
    std::span<const std::byte> type;
    std::int32_t code = 0;
    if (!reader.is(tag_string) || !reader.sized_block(type) || !reader.integer(code)) {
      return "not a vBottle: a list without its type";
    }
    const bool read =
        is_text(type, vision_type) ? read_integers(reader, code, packet.events) : reader.skip(code);
    if (!read) return "a vBottle whose list is broken";
  }
  return {};
}

class Writer {
 public:
  explicit Writer(std::vector<std::byte>& message) : message_(message) { message_.clear(); }

  void integer(std::int32_t value) { block(&value, sizeof(value)); }
  void size(std::size_t size) {
    SACCADE_CHECK(size <= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()));
    integer(static_cast<std::int32_t>(size));
  }
  void block(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::byte*>(data);
    message_.insert(message_.end(), bytes, bytes + size);
  }
  void text(std::string_view text) {
    integer(tag_string);
    size(text.size());
    block(text.data(), text.size());
  }
  void words(const std::vector<WireEvent>& events, bool stamped) {
    for (const WireEvent& event : events) {
      SACCADE_CHECK(event.stamp >> 31 == 0);
      if (stamped) block(&event.stamp, sizeof(event.stamp));
      block(&event.address, sizeof(event.address));
    }
  }

 private:
  std::vector<std::byte>& message_;
};

}  // namespace

const std::vector<std::string>& packet_format_names() {
  static const std::vector<std::string> names = {"packet", "stamped_packet", "vbottle"};
  return names;
}

std::string_view read_packet(std::span<const std::byte> message, PacketFormat format, EventPacket& packet) {
  packet.duration_us = 0;
  packet.events.clear();
  Reader reader(message);
  std::int32_t count = 0;
  if (!reader.is(tag_list) || !reader.integer(count) || count < 0) return "not a list";
  std::string_view problem;
  if (format == PacketFormat::vbottle) {
    problem = read_vbottle(reader, count, packet);
  } else if (count > 0) {
    problem = read_ev_packet(reader, count, has_stamps(format), packet);
  }
  if (problem.empty() && reader.size() > 0) problem = "something comes after the end";
  if (!problem.empty()) packet.events.clear();
  return problem;
}

void write_packet(const EventPacket& packet, PacketFormat format, std::vector<std::byte>& message) {
  Writer writer(message);
  const bool stamped = has_stamps(format);
  const std::size_t count = packet.events.size();
  writer.integer(tag_list);
  if (format == PacketFormat::vbottle) {
    writer.integer(2);
    writer.text(vision_type);
    writer.integer(tag_list | tag_int32);
    writer.size(2 * count);
  } else {
    SACCADE_CHECK(packet.duration_us > 0 && packet.duration_us <= std::numeric_limits<std::int32_t>::max());
    writer.integer(3);
    writer.text(vision_type);
    writer.integer(tag_int32);
    writer.integer(static_cast<std::int32_t>(packet.duration_us));
    writer.integer(tag_string);
    writer.size(count * (stamped ? 8 : 4));
  }
  writer.words(packet.events, stamped);
}

}  // namespace saccade
