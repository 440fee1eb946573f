#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/event.h"

namespace saccade::inline v0_1 {

/// Throws InputError with the file's name for an event outside the image, and for a camera that is not one of the first
/// `cameras`.
void check_writable(const Event& event, ImageSize image_size, int cameras, const std::filesystem::path& path);

/// Formats that store an offset of the time write times in [-largest_offset_us, largest_offset_us]: sums of two of them
/// fit into 64 bits.
inline constexpr std::int64_t largest_offset_us = std::int64_t{1} << 61;

/// "304x240"; text after it is ignored.
[[nodiscard]] std::optional<ImageSize> parse_size(std::string_view text);
[[nodiscard]] std::string text_of(ImageSize size);

/// Appends "12 triggers" to a list of what a reader skipped, after a comma; nothing where `count` is 0.
void append_count(std::string& text, std::int64_t count, std::string_view what);

/// The first bytes of a file for a message, a dot for each one that is not printable ASCII.
[[nodiscard]] std::string printable(std::string_view bytes);

}  // namespace saccade::inline v0_1
