#include "recording/event_packet.h"

#include <array>

#include "recording/byte_order.h"
#include "recording/codec.h"

namespace saccade {
namespace {

void decode_mono(std::string_view bytes, std::uint64_t time_base_ns, std::vector<Event>& events) {
  events.reserve(events.size() + bytes.size() / 8);
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) {
    const auto word = load_little<std::uint64_t>(bytes.data());
    events.push_back({us_of(time_base_ns + (word & 0xffffffff)), static_cast<std::uint16_t>(word >> 32),
                      static_cast<std::uint16_t>(word >> 48 & 0x7fff), word >> 63 != 0, 0});
  }
}

void decode_libcaer(std::string_view bytes, std::uint64_t time_base_ns, std::vector<Event>& events) {
  std::int64_t wraps_us = 0;
  std::int32_t last = 0;
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) {
    const auto data = load_little<std::uint32_t>(bytes.data());
    const auto stamp = load_little<std::int32_t>(bytes.data() + 4);
    if (stamp < last) wraps_us += std::int64_t{1} << 31;
    last = stamp;
    events.push_back({us_of(time_base_ns) + wraps_us + stamp, static_cast<std::uint16_t>(data >> 17 & 0x7fff),
                      static_cast<std::uint16_t>(data >> 2 & 0x7fff), (data >> 1 & 1) != 0, 0});
  }
}

void decode_libcaer_cmp(std::string_view bytes, std::uint64_t time_base_ns, EvtCounts& counts,
                        std::vector<Event>& events) {
  enum Type : unsigned { time_high, time_low, x_address, y_event, vector_base, vector_8 };
  constexpr unsigned vector_rows = 8;
  std::uint64_t high = 0;
  std::uint64_t low = 0;
  std::int64_t t_us = us_of(time_base_ns);
  std::uint16_t x = 0;
  unsigned base_y = 0;
  bool base_on = false;
  for (; bytes.size() >= 2; bytes.remove_prefix(2)) {
    const auto word = load_little<std::uint16_t>(bytes.data());
    const unsigned type = word >> 12;
    const bool on = (word & 0x800) != 0;
    if (type == time_high || type == time_low) {
      (type == time_high ? high : low) = word & 0xfff;
      t_us = us_of(time_base_ns + (high << 12 | low) * 1000);
    } else if (type == x_address) {
      x = word & 0x7ff;
    } else if (type == y_event) {
      events.push_back({t_us, x, static_cast<std::uint16_t>(word & 0x7ff), on, 0});
    } else if (type == vector_base) {
      base_y = word & 0x7ff;
      base_on = on;
    } else if (type == vector_8) {
      for (unsigned row = 0; row < vector_rows; ++row) {
        if ((word >> row & 1) != 0)
          events.push_back({t_us, x, static_cast<std::uint16_t>(base_y + row), base_on, 0});
      }
      base_y += vector_rows;
    } else {
      ++counts.undefined[type];
    }
  }
}

void decode_triggers(std::string_view bytes, std::uint64_t time_base_ns, const EvtTriggers& triggers,
                     EvtCounts& counts) {
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) {
    const auto word = load_little<std::uint64_t>(bytes.data());
    triggers.found(us_of(time_base_ns + (word & 0xffffffff)), static_cast<unsigned>(word >> 48 & 0x7fff),
                   word >> 63 != 0, counts);
  }
}

template <class Decoder>
void decode_words(Decoder& decoder, std::string_view bytes, std::vector<Event>& events) {
  std::array<Event, 4096> block;
  while (bytes.size() >= Decoder::word_bytes) {
    const auto step = decoder.run(bytes, block);
    events.insert(events.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(step.events));
    bytes.remove_prefix(step.words * Decoder::word_bytes);
  }
}

/// Bytes of a word of an encoding; 0 for an unknown one.
std::size_t word_bytes_of(std::string_view encoding) {
  if (encoding == "mono" || encoding == "libcaer" || encoding == "trigger") return 8;
  if (encoding == "evt2") return Evt2Decoder::word_bytes;
  return encoding == "evt3" || encoding == "libcaer_cmp" ? Evt3Decoder::word_bytes : 0;
}

}  // namespace

std::optional<BrokenMessage> PacketDecoder::decode(std::string_view encoding, std::uint64_t time_base_ns,
                                                   std::string_view bytes, std::vector<Event>& events) {
  const std::size_t word_bytes = word_bytes_of(encoding);
  if (word_bytes == 0)
    return BrokenMessage{"a packet in the encoding " + printable(encoding),
                         "mono, libcaer, libcaer_cmp, evt2, evt3 or trigger"};
  if (encoding == "mono") {
    decode_mono(bytes, time_base_ns, events);
  } else if (encoding == "libcaer") {
    decode_libcaer(bytes, time_base_ns, events);
  } else if (encoding == "libcaer_cmp") {
    decode_libcaer_cmp(bytes, time_base_ns, other_counts_, events);
  } else if (encoding == "trigger") {
    decode_triggers(bytes, time_base_ns, triggers_, other_counts_);
  } else if (encoding == "evt2") {
    decode_words(evt2_, bytes, events);
  } else {
    decode_words(evt3_, bytes, events);
  }
  if (bytes.size() % word_bytes != 0)
    return BrokenMessage{"a packet that ends inside its events", "a whole packet"};
  return std::nullopt;
}

}  // namespace saccade
