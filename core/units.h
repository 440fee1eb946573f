#pragma once

#include <numbers>
#include <string>

#include "core/event.h"

namespace saccade {

/// Factors between degrees (YAML keys, YARP) and radians (everything else).
inline constexpr double rad_per_deg = std::numbers::pi / 180.0;
inline constexpr double deg_per_rad = 180.0 / std::numbers::pi;

/// An image size in messages: "128 x 128 pixels".
[[nodiscard]] inline std::string in_words(ImageSize size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height) + " pixels";
}

}  // namespace saccade
