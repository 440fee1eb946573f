#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/event.h"

namespace saccade {

/// Keys of the info file beside an event-driven log (recording/yarp_log_codec.h), lines `Key: value;`.
inline constexpr std::string_view yarp_type_key = "Type: ", yarp_codec_key = "Codec: ",
                                  yarp_size_key = "Size: ", yarp_bits_key = "Bits: ",
                                  yarp_origin_key = "Origin: ";

/// `info.log` beside data.log and binaryevents.log, `NAME.info.log` beside any other NAME.log.
[[nodiscard]] std::filesystem::path yarp_info_file(const std::filesystem::path& log);

/// The value of `key` in the info file of a log; empty where there is no such line.
[[nodiscard]] std::string yarp_info(const std::filesystem::path& log, std::string_view key);

/// The number of `key`; `otherwise` where there is no such line. Throws InputError for a number outside [-largest,
/// largest].
[[nodiscard]] std::int64_t yarp_info_number(const std::filesystem::path& log, std::string_view key,
                                            std::int64_t largest, std::int64_t otherwise);

/// The size in a line `Size: WxH;`. Throws InputError for anything else there.
[[nodiscard]] std::optional<ImageSize> yarp_info_size(const std::filesystem::path& log);

}  // namespace saccade
