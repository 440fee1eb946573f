#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "recording/evt2_decoder.h"
#include "recording/evt3_decoder.h"
#include "recording/message_cursor.h"

namespace saccade {

/// The events of an EventPacket by its encoding (github.com/ros-event-camera/event_camera_msgs), little-endian:
///
/// `mono` 64 bits: ns after time_base 32, x 16, y 15, ON 1.
/// `libcaer` 64 bits: 1 valid, ON 1, y 15, x 15, then us after time_base 31; continued over their wraps in the packet.
/// `libcaer_cmp` 16 bits, type in the upper 4: 0 the upper and 1 the lower 12 bits of the us after time_base, both 0 at the
/// packet's start; 2 x (11 bits); 3 an event at y (11) of polarity bit 11; 4 the y and polarity where vectors begin; 5 a
/// vector, a bit for each of the next 8 rows, from the lowest.
/// `evt2`, `evt3`: the sensor's words (recording/evt_codec.h); times are its counter, continued over its wraps.
/// `trigger` 64 bits, no events: ns after time_base 32, unused 16, channel 15, rising 1.
/// Words of undefined types are counted and left out.
class PacketDecoder {
 public:
  /// Triggers go to `others` (null: are skipped), as those of `source`.
  void pass_triggers_to(OtherRecords* others, const std::string& source) {
    evt2_.triggers().pass_to(others, source);
    evt3_.triggers().pass_to(others, source);
    triggers_.pass_to(others, source);
  }
  /// Appends the events, those before a broken place too.
  [[nodiscard]] std::optional<BrokenMessage> decode(std::string_view encoding, std::uint64_t time_base_ns,
                                                    std::string_view bytes, std::vector<Event>& events);

  /// Words that are left out.
  [[nodiscard]] EvtCounts counts() const {
    EvtCounts all = evt2_.counts();
    all += evt3_.counts();
    all += other_counts_;
    return all;
  }

 private:
  Evt2Decoder evt2_;
  Evt3Decoder evt3_;
  EvtCounts other_counts_;  ///< of the other encodings
  EvtTriggers triggers_;    ///< of the encoding trigger
};

}  // namespace saccade
