#pragma once

#include "core/baselines/surface_detector.h"

namespace saccade {

/// Tracking on an exponential reduced ordinal surface (EROS) by convolution kernels, as PUCK does (KernelSearch). The
/// defaults of the surface are those of the authors' event-driven library.
struct ErosConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  std::int64_t kernel_px = 5;                  ///< side of the square around an event that decays, odd
  double decay = 0.3;                          ///< factor of a pixel after kernel_px events near it
  double threshold = 0.125;                    ///< response taken for the ball: a quarter of a thin outline
};

/// Keys: radius_px, kernel_px, decay, threshold.
void describe(FieldVisitor& v, ErosConfig& config);

/// The exponential reduced ordinal surface of Glover, Gava et al. An event multiplies the pixels of the square of
/// kernel_px x kernel_px around it by decay^(1 / kernel_px), then sets its own pixel to 255. Polarity and time have no
/// effect. Values below 1e-3 become 0.
class ErosSurface {
 public:
  ErosSurface(const ErosConfig& config, ImageSize size);

  void add(const Event& event);
  /// A value in [0, 255] for each pixel, row by row.
  [[nodiscard]] std::span<const double> values() const { return values_; }

 private:
  ImageSize size_;
  int half_px_;
  double factor_;
  std::vector<double> values_;
};

/// Score: response of the kernel, at most 1; 0.5 for a thin closed outline.
using ErosDetector = SurfaceDetector<ErosConfig, ErosSurface>;

}  // namespace saccade
