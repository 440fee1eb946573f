#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "apps/view/snapshot.h"
#include "evaluation/report/palette.h"

namespace saccade {

using Rgb = std::array<std::uint8_t, 3>;
using RgbImage = std::vector<std::uint8_t>;  ///< row by row, three bytes per pixel

inline constexpr Rgb on_rgb = {on_colour.red, on_colour.green, on_colour.blue};
inline constexpr Rgb ground_rgb = {17, 17, 19};  ///< of an image without events
inline constexpr Rgb off_rgb = {off_colour.red, off_colour.green, off_colour.blue};

/// Paints the newest event of each pixel in the colour of its polarity, paler with age, over the darkened camera image
/// or a dark ground. Events older than fade_us (> 0) are not drawn.
void paint_eye(const Snapshot& snapshot, std::int64_t fade_us, bool with_image, RgbImage& rgb);

/// Paints the Hough space from black over red to white at its maximum; black where there is none.
void paint_hough(const Snapshot& snapshot, RgbImage& rgb);

/// Paints event counts from left to right as bars on a dark ground, the largest as high as the image.
void paint_event_counts(std::span<const float> counts, ImageSize size, RgbImage& rgb);

/// Paints the events of the last span_us as points in a box of image and time, seen from the side, the newest in front.
/// `azimuth_rad` and `elevation_rad` turn the box.
void paint_event_cloud(const Snapshot& snapshot, std::int64_t span_us, double azimuth_rad,
                       double elevation_rad, ImageSize size, RgbImage& rgb);

}  // namespace saccade
