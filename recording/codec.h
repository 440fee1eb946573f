#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/event.h"

namespace saccade {

/// What every writer refuses, with an InputError that names the file: an event outside the image, and an event of
/// another than the first `cameras`.
void check_writable(const Event& event, ImageSize image_size, int cameras, const std::filesystem::path& path);

/// "304x240", with or without anything behind it.
[[nodiscard]] std::optional<ImageSize> parse_size(std::string_view text);
[[nodiscard]] std::string text_of(ImageSize size);

/// Appends "12 triggers" to what a reader passed over, behind a comma; nothing where there were none.
void append_count(std::string& text, std::int64_t count, std::string_view what);

/// What a message shows of a file: its first bytes, a dot for each one that is not printable ASCII.
[[nodiscard]] std::string printable(std::string_view bytes);

}  // namespace saccade
