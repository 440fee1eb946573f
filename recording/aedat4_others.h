#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "recording/event_packet.h"
#include "recording/other_records.h"

namespace saccade {

/// Whether `others` wants the packets of a stream of this type ("FRME", "IMUS", "TRIG") of AEDAT 4.0.
[[nodiscard]] bool wants_aedat4(const OtherRecords& others, std::string_view type);

/// Passes on what a packet of such a stream has. `packet`: decompressed, with its size in front. Returns what is broken in it.
[[nodiscard]] std::optional<BrokenMessage> read_aedat4_others(std::string_view type, std::string_view packet,
                                                              std::string_view source, OtherRecords& others);

}  // namespace saccade
