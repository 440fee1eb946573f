#include "core/baselines/eros.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

constexpr double least_value = 1e-3;  // smaller ones would become subnormal in the end, and slow

}  // namespace

void describe(FieldVisitor& v, ErosConfig& config) {
  describe_radius_px(v, config.radius_px);
  v.integer("kernel_px", config.kernel_px, {1, 31}, "side of the square around an event that decays");
  v.require(config.kernel_px % 2 == 1, "kernel_px", std::to_string(config.kernel_px), "an odd number");
  v.real("decay", config.decay, {0.0, 1.0}, "factor of a pixel after kernel_px events near it");
  v.real("threshold", config.threshold, {0.0, 1.0}, "response taken for the ball");
}

ErosSurface::ErosSurface(const ErosConfig& config, ImageSize size)
    : size_(size),
      half_px_(static_cast<int>(config.kernel_px / 2)),
      factor_(std::pow(config.decay, 1.0 / static_cast<double>(config.kernel_px))),
      values_(static_cast<std::size_t>(size.pixels()), 0.0) {}

void ErosSurface::add(const Event& event) {
  const int x_begin = std::max(0, event.x - half_px_);
  const int x_end = std::min(size_.width, event.x + half_px_ + 1);
  const int y_end = std::min(size_.height, event.y + half_px_ + 1);
  for (int y = std::max(0, event.y - half_px_); y < y_end; ++y) {
    double* const row = values_.data() + static_cast<std::ptrdiff_t>(y) * size_.width;
    for (int x = x_begin; x < x_end; ++x) {
      const double value = row[x] * factor_;
      row[x] = value < least_value ? 0.0 : value;
    }
  }
  values_[static_cast<std::size_t>(event.y * size_.width + event.x)] = 255.0;
}

}  // namespace saccade
