#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"

namespace saccade {

/// Throws InputError with the file's name for an event outside the image, and for a camera that is not one of the first
/// `cameras`.
void check_writable(const Event& event, ImageSize image_size, int cameras, const std::filesystem::path& path);

/// Formats that store an offset of the time write times in [-largest_offset_us, largest_offset_us]: sums of two of them
/// fit into 64 bits.
inline constexpr std::int64_t largest_offset_us = std::int64_t{1} << 61;

/// How a message about times that a format cannot hold ends, where times from 0 on would do.
inline constexpr std::string_view zero_time_hint = "--zero-time of saccade convert begins at 0";

/// A coordinate that is counted from the far side of an image, whose last column or row is `last`, counted from the near
/// side. A pixel outside the image keeps its number, at most 65535, and so lies outside here too.
[[nodiscard]] inline std::uint16_t mirrored(std::uint32_t stored, std::uint32_t last) {
  return static_cast<std::uint16_t>(stored <= last ? last - stored : std::min(stored, 65535u));
}

/// "304x240"; text after it is ignored.
[[nodiscard]] std::optional<ImageSize> parse_size(std::string_view text);
[[nodiscard]] std::string text_of(ImageSize size);

/// "auto, evt2, evt3"
[[nodiscard]] std::string joined(const std::vector<std::string>& names);

/// Appends "12 triggers" to a list of what a reader skipped, after a comma; nothing where `count` is 0.
void append_count(std::string& text, std::int64_t count, std::string_view what);

/// The first bytes of a file for a message, a dot for each one that is not printable ASCII.
[[nodiscard]] std::string printable(std::string_view bytes);

}  // namespace saccade
