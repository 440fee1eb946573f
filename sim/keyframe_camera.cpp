#include "sim/keyframe_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/error.h"
#include "sim/lens_resampler.h"

namespace saccade::detail {
namespace {

/// The samples [first, last) along one image axis that the outline of a sphere spans; see EyeRenderer.
std::array<int, 2> outline_span(double dx, double dz, double radius, double focal, double centre) {
  const double r2 = radius * radius;
  const double root = radius * std::sqrt(std::max(dx * dx + dz * dz - r2, 0.0));
  const double scale = focal / (dz * dz - r2);
  constexpr double farthest = 1e6;  // far outside any image
  return {static_cast<int>(std::clamp(std::floor(centre + scale * (dx * dz - root)), -farthest, farthest)),
          static_cast<int>(std::clamp(std::ceil(centre + scale * (dx * dz + root)), -farthest, farthest))};
}

/// Width and height of the pixel around a pixel position, on the plane at unit depth.
Eigen::Vector2d extent_of_pixel(const Camera& camera, const Eigen::Vector2d& at_px) {
  const double x = at_px.x();
  const double y = at_px.y();
  return {std::abs(camera.ray(x + 0.5, y).x() - camera.ray(x - 0.5, y).x()),
          std::abs(camera.ray(x, y + 0.5).y() - camera.ray(x, y - 0.5).y())};
}

}  // namespace

SampleRect SampleRect::cut(const SampleRect& by) const {
  return {std::max(left, by.left), std::max(top, by.top), std::min(right, by.right),
          std::min(bottom, by.bottom)};
}

KeyframeCamera::KeyframeCamera(const Camera& camera, std::int64_t samples, double margin_px)
    : samples_(static_cast<int>(samples)), focal_(static_cast<double>(samples) * camera.fy_px) {
  const int width = camera.size.width;
  const int height = camera.size.height;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  const auto include = [&](int x, int y) {
    const Eigen::Vector2d corner = focal_ * camera.ray(x - 0.5, y - 0.5).head<2>();
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  };
  for (int x = 0; x <= width; ++x) {
    include(x, 0);
    include(x, height);
  }
  for (int y = 0; y <= height; ++y) {
    include(0, y);
    include(width, y);
  }
  const double margin = std::ceil(margin_px * static_cast<double>(samples));
  const Eigen::Vector2d size = (high - low).array() + 2.0 * margin;
  if (!(size.maxCoeff() < LensResampler::max_side)) {
    throw InputError("render.keyframe_samples",
                     std::to_string(samples) + " of this camera: a keyframe of " +
                         text_of(std::ceil(size.x())) + " x " + text_of(std::ceil(size.y())) + " samples",
                     "at most " + std::to_string(LensResampler::max_side) + " samples in width and height");
  }
  columns_ = static_cast<int>(std::ceil(size.x()));
  rows_ = static_cast<int>(std::ceil(size.y()));
  centre_x_ = margin - low.x();
  centre_y_ = margin - low.y();

  cell_columns_ = static_cast<std::size_t>((columns_ + cell - 1) / cell);
  const int cell_rows = (rows_ + cell - 1) / cell;
  for (int row = 0; row < cell_rows; ++row) {
    for (std::size_t column = 0; column < cell_columns_; ++column) {
      Eigen::Vector3d point((static_cast<double>(column) * cell + 0.5 * cell - centre_x_) / focal_,
                            (row * cell + 0.5 * cell - centre_y_) / focal_, 1.0);
      std::optional<Eigen::Vector2d> at_px = camera.project(point);
      while (!at_px) {  // beyond the lens
        point.head<2>() *= 0.9;
        at_px = camera.project(point);
      }
      const Eigen::Vector2d inside_px(std::clamp(at_px->x(), 0.0, width - 1.0),
                                      std::clamp(at_px->y(), 0.0, height - 1.0));
      // Interpolation between samples adds a mean over one sample: the filter's width leaves it out, so that both together
      // have the variance of the pixel.
      const Eigen::Vector2d square =
          (focal_ * extent_of_pixel(camera, inside_px)).cwiseAbs2().cwiseMax(2.0) - Eigen::Vector2d::Ones();
      cells_.push_back(
          {static_cast<float>(std::sqrt(square.x())), static_cast<float>(std::sqrt(square.y()))});
      const float longer = std::max(cells_.back().width, cells_.back().height);
      reach_ = std::max(reach_, static_cast<int>(std::lround(0.5F * longer)) + 1);
    }
  }
}

void KeyframeCamera::set_frustum(const SampleRect& rect, mjvGLCamera& eye) const {
  const double per_sample = static_cast<double>(eye.frustum_near) / focal_;
  eye.frustum_center = static_cast<float>(per_sample * (0.5 * (rect.left + rect.right) - centre_x_));
  eye.frustum_top = static_cast<float>(per_sample * (centre_y_ - rect.top));
  eye.frustum_bottom = static_cast<float>(per_sample * (centre_y_ - rect.bottom));
}

std::optional<SampleRect> KeyframeCamera::span_of(const Eigen::Vector3d& centre_m, double radius_m,
                                                  double near_m) const {
  if (centre_m.z() - radius_m < near_m) return std::nullopt;
  const auto [left, right] = outline_span(centre_m.x(), centre_m.z(), radius_m, focal_, centre_x_);
  const auto [top, bottom] = outline_span(centre_m.y(), centre_m.z(), radius_m, focal_, centre_y_);
  return SampleRect{left, top, right, bottom};
}

}  // namespace saccade::detail
