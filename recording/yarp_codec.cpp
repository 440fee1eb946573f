#include "recording/yarp_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace saccade {
namespace {

constexpr ImageSize dvs_size{128, 128};
constexpr ImageSize atis_size{304, 240};
constexpr std::array<YarpCodec, 6> codecs{{
    {"dvs_128", AddressCodec::dvs_128, 24, dvs_size, false, true},
    {"dvs_128_upright", AddressCodec::dvs_128, 24, dvs_size, true, true},
    {"atis_20", AddressCodec::atis_20, 24, atis_size, false, true},
    {"atis_24", AddressCodec::atis_24, 0, atis_size, false, true},
    {"ev2", AddressCodec::ev2, 0, std::nullopt, false, false},
    {"ev2_ts", AddressCodec::ev2, 0, std::nullopt, false, true},
}};

constexpr std::uint32_t stamp_mask = 0x7fffffff;
/// Set in the stamps of before 2018, whose counters have 24 bits.
constexpr std::uint32_t old_stamp = 1u << 31;
constexpr std::uint32_t ev2_fill = 0x3fu << 26;
constexpr std::int64_t longest_lateness = std::int64_t{1} << 23;

/// Null for a name that is not in the table.
const YarpCodec* find_codec(std::string_view name) {
  const auto it = std::ranges::find(codecs, name, &YarpCodec::name);
  return it == codecs.end() ? nullptr : &*it;
}

/// Whether every other word of packets of bytes looks like a time stamp: they rise, but for a wrap, and the words
/// between them are addresses, which do not.
bool look_stamped(std::span<const YarpPacket> packets) {
  std::uint32_t last_stamp = 0;
  std::uint32_t last_address = 0;
  std::int64_t pairs = 0, stamps_back = 0, stamps_forth = 0, addresses_back = 0;
  bool stamps_are_addresses = true;
  for (const YarpPacket& packet : packets) {
    if (!packet.of_bytes || packet.words.size() % 2 != 0) return false;
    for (std::size_t i = 0; i < packet.words.size(); i += 2) {
      const std::uint32_t stamp = packet.words[i];
      const std::uint32_t address = packet.words[i + 1];
      if ((address & ev2_fill) != 0) return false;
      if (pairs++ > 0) {
        stamps_back += stamp < last_stamp ? 1 : 0;
        stamps_forth += stamp > last_stamp ? 1 : 0;
        addresses_back += address < last_address ? 1 : 0;
      }
      stamps_are_addresses = stamps_are_addresses && (stamp & ev2_fill) == 0;
      last_stamp = stamp;
      last_address = address;
    }
  }
  if (pairs > 0 && !stamps_are_addresses) return true;
  return stamps_forth > 0 && stamps_back <= 1 && addresses_back > stamps_back;
}

}  // namespace

std::optional<Event> YarpCodec::decode(std::int64_t t_us, std::uint32_t word) const {
  std::optional<Event> event = decode_address(word, address);
  if (!event) return event;
  event->t_us = t_us;
  if (upright) {
    const std::uint16_t x = event->x;
    event->x = event->y;
    event->y = static_cast<std::uint16_t>(dvs_size.height - 1 - x);
  }
  return event;
}

const YarpCodec& yarp_codec(std::string_view name, std::string_view place) {
  if (const YarpCodec* codec = find_codec(name)) return *codec;
  std::string names;
  for (const YarpCodec& known : codecs) names += (names.empty() ? "" : ", ") + std::string(known.name);
  throw InputError(std::string(place), std::string(name), "one of auto, " + names);
}

const YarpCodec& guess_yarp_codec(std::span<const YarpPacket> packets) {
  const bool bytes = std::ranges::any_of(packets, [](const YarpPacket& p) { return p.of_bytes; });
  if (bytes) return *find_codec(look_stamped(packets) ? "ev2_ts" : "ev2");
  std::uint32_t used = 0;
  for (const YarpPacket& packet : packets) {
    for (std::size_t i = 1; i < packet.words.size(); i += 2) used |= packet.words[i];
  }
  constexpr std::uint32_t atis_24_fill = 1u << 11;
  if ((used & atis_24_fill) == 0 || used >= 1u << 22) return *find_codec("atis_24");
  return *find_codec(used < 1u << 16 ? "dvs_128" : "atis_20");
}

std::int64_t StampUnwrapper::extend(std::uint32_t stamp_word, double host_s) {
  if ((stamp_word & old_stamp) != 0) bits_ = 24;
  const std::int64_t stamp = stamp_word & stamp_mask;
  if (bits_ > 0 && stamp >> bits_ != 0) bits_ = 0;
  if (!started_) {
    last_ = stamp;
    last_host_s_ = host_s;
    started_ = true;
  }
  largest_ = std::max(largest_, stamp);
  const std::int64_t step = stamp - last_;
  const double elapsed = (host_s - last_host_s_) * ticks_per_s_;
  if (bits_ > 0) {
    offset_ += wraps_of_known(step, elapsed);
  } else if (std::abs(step) > longest_lateness) {
    offset_ += wrap_of_unknown(step, elapsed);
  }
  last_ = stamp;
  last_host_s_ = host_s;
  return offset_ + stamp;
}

/// As many rounds as bring the step closest to what went by at the host, or, without the host's time, to nothing.
std::int64_t StampUnwrapper::wraps_of_known(std::int64_t step, double elapsed) const {
  const std::int64_t range = std::int64_t{1} << bits_;
  const double missing = (std::isfinite(elapsed) ? elapsed : 0.0) - static_cast<double>(step);
  return std::llround(missing / static_cast<double>(range)) * range;
}

/// What to add to a step so that it comes closest to the ticks that went by at the host: nothing, a wrap forward for a
/// step back, or, for an event that is late, the last wrap back again.
std::int64_t StampUnwrapper::wrap_of_unknown(std::int64_t step, double elapsed) const {
  if (!std::isfinite(elapsed)) {
    const auto range = static_cast<std::int64_t>(
        std::bit_ceil(std::max(static_cast<std::uint64_t>(largest_) + 1, std::uint64_t{1} << 24)));
    if (step < -range / 2) return range;
    return step > range / 2 && offset_ >= range ? -range : 0;
  }
  std::int64_t best = 0;
  const auto distance = [&](std::int64_t added) {
    return std::abs(static_cast<double>(step + added) - elapsed);
  };
  for (int bits = 24; bits <= 31; ++bits) {
    const std::int64_t range = std::int64_t{1} << bits;
    const bool possible = range > largest_ && (step < 0 || offset_ >= range);
    const std::int64_t added = step < 0 ? range : -range;
    if (possible && distance(added) < distance(best)) best = added;
  }
  return best;
}

}  // namespace saccade
