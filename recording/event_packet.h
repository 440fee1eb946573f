#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "recording/evt2_decoder.h"
#include "recording/evt3_decoder.h"

namespace saccade {

/// To the nearest us.
[[nodiscard]] inline std::int64_t us_of(std::uint64_t ns) {
  return static_cast<std::int64_t>((ns + 500) / 1000);
}

/// What a message contains that is no such message, and what was expected.
struct BrokenMessage {
  std::string found, expected;
};

/// The events of an EventPacket by its encoding (github.com/ros-event-camera/event_camera_msgs), little-endian:
///
/// `mono` 64 bits: ns after time_base 32, x 16, y 15, ON 1.
/// `libcaer` 64 bits: 1 valid, ON 1, y 15, x 15, then us after time_base 31; continued over their wraps in the packet.
/// `libcaer_cmp` 16 bits, type in the upper 4: 0 the upper and 1 the lower 12 bits of the us after time_base, both 0 at the
/// packet's start; 2 x (11 bits); 3 an event at y (11) of polarity bit 11; 4 the y and polarity where vectors begin; 5 a
/// vector, a bit for each of the next 8 rows, from the lowest.
/// `evt2`, `evt3`: the sensor's words (recording/evt_codec.h); times are its counter, continued over its wraps.
/// Words of undefined types are counted and left out.
class PacketDecoder {
 public:
  /// Appends the events, those before a broken place too. A packet of encoding `trigger` has none.
  [[nodiscard]] std::optional<BrokenMessage> decode(std::string_view encoding, std::uint64_t time_base_ns,
                                                    std::string_view bytes, std::vector<Event>& events);

  /// Words that are left out.
  [[nodiscard]] EvtCounts counts() const {
    EvtCounts all = evt2_.counts();
    all += evt3_.counts();
    all += libcaer_cmp_;
    return all;
  }

 private:
  Evt2Decoder evt2_;
  Evt3Decoder evt3_;
  EvtCounts libcaer_cmp_;
};

}  // namespace saccade
