#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "apps/view/picture.h"

namespace saccade {

using Rgb = std::array<std::uint8_t, 3>;
using RgbImage = std::vector<std::uint8_t>;  ///< row by row, three bytes per pixel

inline constexpr Rgb on_rgb = {255, 92, 70};
inline constexpr Rgb off_rgb = {70, 150, 255};

/// What the eye sees: the newest event of each pixel in the colour of its polarity, the paler the older, over the
/// eye's image, darkened, or over a dark ground. Events older than fade_us (> 0) are gone.
void paint_eye(const Picture& picture, std::int64_t fade_us, bool with_image, RgbImage& rgb);

/// The Hough space from black over red to white at its strongest; black where there is none.
void paint_hough(const Picture& picture, RgbImage& rgb);

/// Parts of a whole, from left to right, as bars on a dark ground, the highest as high as the picture.
void paint_overview(std::span<const float> parts, ImageSize size, RgbImage& rgb);

/// The events of the last span_us as points in the box of image and time, seen from the side: now in front.
/// `azimuth_rad` and `elevation_rad` turn the box.
void paint_cloud(const Picture& picture, std::int64_t span_us, double azimuth_rad, double elevation_rad,
                 ImageSize size, RgbImage& rgb);

}  // namespace saccade
