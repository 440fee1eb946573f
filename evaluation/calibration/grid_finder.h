#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// An asymmetric grid of dark dots on white, as OpenCV has it: dot k of row i is at (2 k + i % 2, i) spacings.
struct DotGrid {
  int columns = 4;  ///< dots in a row
  int rows = 7;     ///< an odd number, so that the grid has one way up
  double spacing_m = 0.025;
  double dot_diameter_m = 0.021;

  [[nodiscard]] std::size_t dots() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// The dots' middles row by row, z = 0, from the middle of the grid: x along a row, y from row to row.
  [[nodiscard]] std::vector<cv::Point3d> points_m() const;
};

/// A picture out of events: how bright each pixel is against the brightest it has been lately.
///
/// The sum of a pixel's signed events follows the logarithm of its brightness, up to an unknown beginning and a slow
/// drift. Both cancel in the difference to the sum's largest value within the last window (to twice that): where
/// the window is long enough for white to have passed, white is 1 and a dot is what it reflects against white.
/// After an event the brightness has gone on the same way, by up to a threshold: half of one is added.
/// Events without an event of a neighbour in the 150 ms before are taken for noise and left out.
class EventPicture {
 public:
  /// `window_us`: in which white passes every pixel of the board. `refractory_us`: how long a pixel sees nothing
  /// after an event; what it missed in a burst of events, as long as that takes, is added to the next one.
  EventPicture(ImageSize size, std::int64_t window_us, std::int64_t refractory_us);

  /// Sorted by time, all inside the image.
  void add(std::span<const Event> events);
  /// As of now_us, at or after the events added: height x width, float, 0 to 1.
  [[nodiscard]] cv::Mat picture(std::int64_t now_us) const;

 private:
  struct Pixel {
    float level = 0.0F;           // log brightness at the last event, from an unknown beginning
    float ahead = 0.0F;           // how far it is likely to have gone on since
    float highest = 0.0F;         // in the window at hand
    float highest_before = 0.0F;  // in the one before
    std::int64_t window = 0;      // the number of the window at hand
  };
  [[nodiscard]] static Pixel at_window(Pixel pixel, std::int64_t window);

  ImageSize size_;
  std::int64_t window_us_;
  std::int64_t refractory_us_;
  std::vector<Pixel> pixels_;
  std::vector<std::int64_t> newest_us_;  // with a border of one pixel
};

/// The dots of a grid in one picture.
struct GridView {
  std::int64_t t_us = 0;
  std::vector<cv::Point2d> dots_px;  ///< centroids, in the order of DotGrid::points_m()
  double speed_px_s = 0.0;           ///< of the fastest dot
};

/// Finds all dots of the grid; none where one is missing or not dark throughout. A dot is the centroid of its darkness.
[[nodiscard]] std::optional<std::vector<cv::Point2d>> find_grid(const cv::Mat& picture, const DotGrid& grid);

}  // namespace saccade
