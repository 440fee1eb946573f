#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "recording/address_event.h"

namespace saccade {

/// Layout of an event-driven log, which the log itself does not contain: its address words (AddressCodec) and their time
/// stamps.
///
/// | name            | stamps                                                                                     |
/// |-----------------|--------------------------------------------------------------------------------------------|
/// | dvs_128         | 24 bits of 128 ns; x and y as stored                                                       |
/// | dvs_128_upright | the same; pixel (y, 127 - x) of those, as the robot of 2016 held its cameras               |
/// | atis_20         | 24 bits of 80 ns                                                                           |
/// | atis_24         | 24 to 31 bits of 80 ns                                                                     |
/// | ev2             | none in packets of bytes (versions of 2021 and later), elsewhere as atis_24                |
/// | ev2_ts          | one before each address in packets of bytes too (VLIB_ENABLE_TS), 24 to 31 bits of 80 ns   |
struct YarpCodec {
  std::string_view name;
  AddressCodec address = AddressCodec::atis_24;
  int stamp_bits = 0;  ///< 0: not part of the codec
  std::optional<ImageSize> image_size;
  bool upright = false;  ///< x and y are turned as in the table
  bool stamped = true;   ///< in packets of bytes; pairs of numbers are always

  /// None where the word is a skin event.
  [[nodiscard]] std::optional<Event> decode(std::int64_t t_us, std::uint32_t word) const;
};

/// Throws InputError for a name that is not in the table; `place`: where it was given.
[[nodiscard]] const YarpCodec& yarp_codec(std::string_view name, std::string_view place);

/// One packet of a log.
struct YarpPacket {
  double host_s = 0.0;  ///< NaN where the log has none
  std::int64_t host_us = 0;
  std::int64_t duration_us = 0;
  bool of_bytes = false;  ///< a version 2 packet; else pairs of stamp and address
  std::vector<std::uint32_t> words;
};

/// The codec that the first packets of a log look like. Pairs: bit 11 is empty in atis_24 and part of y in the older
/// codecs, of which the DVS's has 16 bits. Bytes: stamped where every other word only rises. A guess: a log that is
/// short or of few pixels may be taken for another codec.
[[nodiscard]] const YarpCodec& guess_yarp_codec(std::span<const YarpPacket> packets);

/// Continues time stamps over the wraps of their counter.
///
/// For a counter of known width the number of wraps during a silence follows from the host's time. An unknown width
/// is the one of 24 to 31 bits that brings a jump of the stamps closest to the host's time. Without a host's time
/// a step back is a wrap of the narrowest counter that holds all stamps so far.
class StampUnwrapper {
 public:
  StampUnwrapper(std::int64_t ns_per_tick, int stamp_bits)
      : ticks_per_s_(1e9 / static_cast<double>(ns_per_tick)), bits_(stamp_bits) {}

  /// Ticks since the counter's zero. Stamps that need more bits than the given width make the width unknown.
  std::int64_t extend(std::uint32_t stamp_word, double host_s);

 private:
  [[nodiscard]] std::int64_t wraps_of_known(std::int64_t step, double elapsed) const;
  [[nodiscard]] std::int64_t wrap_of_unknown(std::int64_t step, double elapsed) const;

  double ticks_per_s_;
  int bits_;
  bool started_ = false;
  std::int64_t last_ = 0;
  std::int64_t largest_ = 0;
  std::int64_t offset_ = 0;
  double last_host_s_ = 0.0;
};

}  // namespace saccade
