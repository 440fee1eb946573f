#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/event.h"

namespace saccade {

/// What every writer refuses, with an InputError that names the file: an event outside the image, and an event of
/// another than the first `cameras`.
void check_writable(const Event& event, ImageSize image_size, int cameras, const std::filesystem::path& path);

/// What a message shows of a file: its first bytes, a dot for each one that is not printable ASCII.
[[nodiscard]] std::string printable(std::string_view bytes);

}  // namespace saccade
