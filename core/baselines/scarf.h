#pragma once

#include "core/baselines/surface_detector.h"

namespace saccade {

/// Tracking by convolution kernels (KernelSearch) on a set of centre active receptive fields (SCARF). The defaults of the
/// surface are those of the authors' event-driven library.
struct ScarfConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  std::int64_t block_px = 10;  ///< side of the centre of a receptive field; near it, see ScarfSurface
  double alpha = 1.0;          ///< events of a field over half of the pixels of its centre
  double contrast = 0.3;       ///< of an event in the image; 1 is the largest
  double threshold = 0.125;    ///< response taken for the ball
};

/// Keys: radius_px, block_px, alpha, contrast, threshold.
void describe(FieldVisitor& v, ScarfConfig& config);

/// The set of centre active receptive fields of the event-driven library. The image is divided into equal blocks of even
/// side, less half a block at each border. Each block is the centre of a receptive field, which reaches half a block
/// further on each side. A field keeps its newest alpha / 2 x (pixels of a block) events. An event is active in the field
/// in whose centre it lies, and passive in the three fields that reach to it. The surface counts the active events at
/// each pixel, each with 255 x contrast: how long an event stays depends on the events near it alone.
class ScarfSurface {
 public:
  ScarfSurface(const ScarfConfig& config, ImageSize size);

  void add(const Event& event);
  /// A value for each pixel, row by row, from 0 on; from 255 on all are the same to a reader.
  [[nodiscard]] std::span<const double> values() const { return values_; }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  /// Events of a field.
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

 private:
  static constexpr std::int32_t passive = -1;
  void push(int column, int row, std::int32_t pixel);

  ImageSize size_;
  int columns_, rows_;  // of the fields
  int block_width_px_, block_height_px_;
  std::size_t capacity_;
  double value_;                      // of an active event
  std::vector<std::int32_t> events_;  // of each field, a ring: the pixel of an active event, or passive
  std::vector<std::size_t> oldest_;   // of each field
  std::vector<std::int32_t> active_;  // events at each pixel
  std::vector<double> values_;
};

/// Score: response of the kernel, at most 1.
using ScarfDetector = SurfaceDetector<ScarfConfig, ScarfSurface>;

}  // namespace saccade
