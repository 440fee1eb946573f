#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "recording/run_files.h"

namespace saccade {

/// How fast the true circle's centre moves in the image at every row of simulated truth, px/s: the way from
/// 5 ms before to 5 ms after, less at the ends and beside rows without a circle; NaN where there is no circle.
[[nodiscard]] std::vector<double> image_speed_px_s(std::span<const TruthRow> truth);

/// How often a detector found the ball at which speed in the image, over one run or several. A bin reaches
/// from the bound of its number to the next one; the last has no end.
struct SpeedCounts {
  static constexpr std::array<double, 15> bounds_px_s = {0,   10,  14,  20,  28,  40,  57, 80,
                                                         113, 160, 226, 320, 453, 640, 905};
  /// Fewer chances than these, 1 ms each, say too little of a bin.
  static constexpr std::int64_t enough_chances = 50;

  std::array<std::int64_t, bounds_px_s.size()> chances{};
  std::array<std::int64_t, bounds_px_s.size()> found{};

  /// Adds a run. `found_at` as found_at_chances tells it, `speed_px_s` as image_speed_px_s does.
  void add(std::span<const std::optional<bool>> found_at, std::span<const double> speed_px_s);
  /// Detections per second while the ball moves that fast; none with too few chances.
  [[nodiscard]] std::optional<double> rate_hz(std::size_t bin) const;
};

}  // namespace saccade
