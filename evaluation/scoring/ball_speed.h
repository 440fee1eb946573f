#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "recording/run_files.h"

namespace saccade {

/// Speed of the true circle's centre in the image at every row of simulated truth, px/s: its path from 5 ms before to
/// 5 ms after, shorter at the ends and beside rows without a circle; NaN where there is no circle.
[[nodiscard]] std::vector<double> image_speed_px_s(std::span<const TruthRow> truth);

/// Chances and detections by the ball's speed in the image, over one run or several. Bin i reaches from bounds_px_s[i] to
/// the next bound; the last has no end.
struct SpeedCounts {
  static constexpr std::array<double, 15> bounds_px_s = {0,   10,  14,  20,  28,  40,  57, 80,
                                                         113, 160, 226, 320, 453, 640, 905};
  /// A bin with fewer chances, 1 ms each, has no rate.
  static constexpr std::int64_t enough_chances = 50;

  std::array<std::int64_t, bounds_px_s.size()> chances{};
  std::array<std::int64_t, bounds_px_s.size()> found{};

  /// Adds a run. `found_at` from found_at_chances(), `speed_px_s` from image_speed_px_s().
  void add(std::span<const std::optional<bool>> found_at, std::span<const double> speed_px_s);
  /// Detections per second at that speed; none with too few chances.
  [[nodiscard]] std::optional<double> rate_hz(std::size_t bin) const;
};

}  // namespace saccade
