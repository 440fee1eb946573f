#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// An asymmetric grid of dark dots on white, in OpenCV's convention: dot k of row i is at (2 k + i % 2, i) spacings.
struct DotGrid {
  int columns = 4;  ///< dots in a row
  int rows = 7;     ///< an odd number, so that its orientation is unique
  double spacing_m = 0.025;
  double dot_diameter_m = 0.021;

  [[nodiscard]] std::size_t dots() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// The dots' centres row by row, z = 0, relative to the centre of the grid: x along a row, y from row to row.
  [[nodiscard]] std::vector<cv::Point3d> points_m() const;
};

/// An image reconstructed from events: the brightness of each pixel relative to its brightest recent value.
///
/// The sum of a pixel's signed events follows the logarithm of its brightness, up to an unknown start value and a slow
/// drift. Both cancel in the difference to the sum's largest value within the last window (to twice that): where
/// the window is long enough for white to have passed, white is 1 and a dot is its reflectance relative to white.
/// After an event the brightness has changed further in the same direction by up to a threshold: half of one is added.
/// Events without an event of a neighbour in the 150 ms before are taken for noise and ignored.
class ReconstructedImage {
 public:
  /// `window_us`: time in which white passes every pixel of the board. `refractory_us`: time after an event in which
  /// the pixel is blind; the change that it missed then in a burst of events is added to the next one.
  ReconstructedImage(ImageSize size, std::int64_t window_us, std::int64_t refractory_us);

  /// Sorted by time, all inside the image.
  void add(std::span<const Event> events);
  /// As of now_us, at or after the events added: height x width, float, 0 to 1.
  [[nodiscard]] cv::Mat image(std::int64_t now_us) const;

 private:
  struct Pixel {
    float level = 0.0F;           // log brightness at the last event, up to a constant
    float ahead = 0.0F;           // expected change since then
    float highest = 0.0F;         // in the present window
    float highest_before = 0.0F;  // in the previous window
    std::int64_t window = 0;      // number of the present window
  };
  [[nodiscard]] static Pixel at_window(Pixel pixel, std::int64_t window);

  ImageSize size_;
  std::int64_t window_us_;
  std::int64_t refractory_us_;
  std::vector<Pixel> pixels_;
  std::vector<std::int64_t> newest_us_;  // with a border of one pixel
};

/// The dots of a grid in one image.
struct GridView {
  std::int64_t t_us = 0;
  std::vector<cv::Point2d> dots_px;  ///< centroids, in the order of DotGrid::points_m()
  double speed_px_s = 0.0;           ///< of the fastest dot
};

/// Finds all dots of the grid in an image (float, 0 to 1); none where one is missing or not dark throughout.
[[nodiscard]] std::optional<std::vector<cv::Point2d>> find_grid(const cv::Mat& image, const DotGrid& grid);

/// The centroid of the darkness within `reach_px` of a point (image pixels); none where there is no darkness, the middle
/// of the dot is not dark, or the dot reaches over the image's border.
[[nodiscard]] std::optional<cv::Point2d> dot_centroid(const cv::Mat& image, cv::Point2d at, double reach_px);

}  // namespace saccade
