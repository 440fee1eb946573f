#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/detector.h"

namespace saccade {

/// Search for a disc by convolution kernels on an image of recent events, after PUCK (Gava et al., "PUCK: Parallel
/// Surface and Convolution-kernel Tracking for Event-Based Cameras", arXiv:2205.07657, 2022).
///
/// The image is smoothed with a binomial filter of 5 x 5 pixels. The response of a kernel is
///
///     (mean on the outline - 0.75 mean inside - 0.25 mean outside) / 255,
///
/// each over a fixed number of pixels; it is at most 1, and about 0.5 for a thin closed outline. The weights beside the
/// outline have the ratio of PUCK's kernel; they are larger than there, so that an even texture has no response. Kernels of
/// different radii are compared as if each had the same energy: by response x sqrt(radius), their strength.
///
/// One disc is followed: in each step it moves to the largest strength within 3 px and one step of radius. Beside it the
/// whole image is searched, a fixed number of kernels in each step; the best of a search replaces the disc where it is
/// stronger. PUCK has one kernel of known size, searches a given region, and never replaces its disc.
///
/// The work of a step is bounded by constants and the largest radius. Does not allocate after construction.
class KernelSearch {
 public:
  KernelSearch(const std::array<double, 2>& radius_px, ImageSize size);

  /// One step. `surface`: a value for each pixel, row by row; those above 255 count as 255.
  void step(std::span<const double> surface);
  /// Steps in which the whole image is smoothed and searched twice: on a surface that does not change, more of them find
  /// nothing new.
  [[nodiscard]] std::int64_t steps_to_settle() const;
  /// The disc and its response as of the last step; not valid before the first search of the whole image has ended.
  [[nodiscard]] Estimate disc() const;

 private:
  struct Match {
    int x = 0, y = 0;
    std::size_t radius = 0;  // index of the kernel
    double response = -1.0;
    double strength = -1e9;
  };
  // Samples of a kernel: its work does not grow with the radius. Twice as many on the outline as beside it.
  static constexpr int outline_pixels = 48, inside_pixels = 24, outside_pixels = 24;
  struct Kernel {
    int r_px = 0;
    double gain = 0.0;                                 // of the strength over the response
    std::array<std::int32_t, outline_pixels> outline;  // offsets in the smoothed image
    std::array<std::int32_t, inside_pixels> inside;
    std::array<std::int32_t, outside_pixels> outside;
  };

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>((y + margin_) * stride_ + x + margin_);
  }
  [[nodiscard]] Kernel kernel(int r_px) const;
  void smooth(std::span<const double> surface, int x_begin, int x_end, int y_begin, int y_end);
  void consider(Match& best, int x, int y, std::size_t radius) const;
  [[nodiscard]] int rows_to_smooth() const;
  [[nodiscard]] Match largest_near(const Match& start) const;
  void follow(std::span<const double> surface);
  void sweep(std::span<const double> surface);

  ImageSize size_;
  int margin_;
  int stride_;
  std::vector<Kernel> kernels_;
  std::vector<std::uint16_t> level_, row_sum_;  // of the surface, with margins of zeros
  std::vector<std::uint8_t> smooth_;
  Match disc_;
  bool found_ = false;

  // The search of the whole image: places on a grid, each with every second kernel.
  int columns_, rows_;
  std::int64_t sweep_steps_;
  std::int64_t place_ = 0;  // next place of the grid
  int smoothed_row_ = 0;    // next row of the image to smooth
  Match sweep_best_;
};

}  // namespace saccade
