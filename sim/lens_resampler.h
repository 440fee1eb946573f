#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"
#include "threads/worker_threads.h"

namespace saccade {

/// Converts a drawn image into the image of a camera with a lens.
///
/// MuJoCo 2.2.2 draws exact pinholes with square pixels only. The drawn image is large enough for everything that the
/// lens shows, with supersampling^2 samples per pixel on the optical axis. A pixel is the mean of the drawn image over
/// the area of the pixel there: each sample is weighted by the share of it that the pixel covers.
class LensResampler {
 public:
  static constexpr int max_side = 16384;  ///< of the drawn image, samples; no OpenGL buffer is larger

  /// `camera` is checked already. Throws InputError where the drawn image would be larger than max_side, or where the
  /// camera has no ray for a corner of a pixel.
  LensResampler(const Camera& camera, std::int64_t supersampling);

  // The drawn image: size, focal length and principal point, samples from its left and top edge.
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] double focal() const { return focal_; }
  [[nodiscard]] double centre_x() const { return centre_x_; }
  [[nodiscard]] double centre_y() const { return centre_y_; }
  /// Per sample of the drawn image, bottom row first: 1 where at least half of it is inside the camera's image.
  [[nodiscard]] const std::vector<std::uint8_t>& is_inside() const { return is_inside_; }

  // `rgba` is the drawn image, bottom row first; `image` the camera's, row by row from the top, 0 to 255.
  /// Rec. 709 luminance of linear red, green and blue.
  void luminance(std::span<const std::uint32_t> rgba, std::span<float> image, WorkerThreads& threads);
  /// Red, green and blue, as three images one after the other.
  void colour(std::span<const std::uint32_t> rgba, std::span<float> image, WorkerThreads& threads);
  /// The smallest number above 0 among the red channels of a pixel's samples; `nothing` where all are 0.
  void smallest(std::span<const std::uint32_t> rgba, std::uint8_t nothing,
                std::span<std::uint8_t> numbers) const;

 private:
  /// Four samples side by side in the drawn image, and their weights in a pixel.
  struct Samples {
    std::uint32_t first;
    std::array<float, 4> weights;
  };

  /// Of red, green and blue in each channel of an image, in 1/10000.
  template <std::size_t channels>
  using ChannelWeights = std::array<std::array<std::uint32_t, 3>, channels>;
  template <std::size_t channels>
  void resample(std::span<const std::uint32_t> rgba, const ChannelWeights<channels>& weights,
                std::span<float> image, WorkerThreads& threads);
  /// Samples of a channel in drawn_. They are read four at a time, past the end too.
  [[nodiscard]] std::size_t channel_size() const { return is_inside_.size() + 3; }

  int columns_ = 0;
  int rows_ = 0;
  double focal_;
  double centre_x_ = 0.0;
  double centre_y_ = 0.0;
  std::vector<Samples> samples_;            ///< of all pixels, row by row
  std::vector<std::uint32_t> samples_end_;  ///< per pixel: the end of its samples
  std::vector<std::uint8_t> is_inside_;
  std::vector<float> drawn_;  ///< luminance or colours of the drawn image, one channel after the other
};

}  // namespace saccade
