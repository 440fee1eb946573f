#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "core/event.h"
#include "images/image_sequence.h"

namespace saccade {

/// The kinds of image sequences, one file each; open_image_sequence chooses. Throw InputError.
[[nodiscard]] std::unique_ptr<ImageSequence> open_image_folder(const std::filesystem::path& path,
                                                               double white,
                                                               std::span<const ImageTime> named);
[[nodiscard]] std::unique_ptr<ImageSequence> open_video(const std::filesystem::path& path, double white);
[[nodiscard]] std::unique_ptr<ImageSequence> open_npy(const std::filesystem::path& path);

/// ".png" of SHOT.PNG.
[[nodiscard]] std::string lower_case_extension(const std::filesystem::path& path);

/// Width and height of an image that can be read.
inline constexpr int longest_image_side = 16384;
[[nodiscard]] inline bool is_possible_image(ImageSize size) {
  return size.width >= 1 && size.height >= 1 && size.width <= longest_image_side &&
         size.height <= longest_image_side;
}
[[nodiscard]] inline std::string possible_image_sizes() {
  return "width and height in [1, " + std::to_string(longest_image_side) + "]";
}

}  // namespace saccade
