#include "sim/canvas.h"

namespace saccade {

void Canvas::leaf(double x, double y, double length, double width, double angle_rad, Reflectance colour) {
  const double half = 0.5 * length;
  shape(
      x, y, half, angle_rad,
      [=](double u, double v) { return 0.5 * width * (1.0 - (u / half) * (u / half)) - std::abs(v); },
      [=](double u, double v) {
        const double side = 0.85 + 0.3 * std::clamp(v / width + 0.5, 0.0, 1.0) + 0.1 * u / half;
        return (std::abs(v) < 0.05 * width ? 1.25 : side) * colour;
      });
}

void Canvas::lay(Canvas& other, double x, double y, double angle_rad) {
  tilted(x, y, other.width(), other.height(), angle_rad, [&other](double u, double v) {
    const int column = static_cast<int>((u + 0.5 * other.width_m_) / other.texel_m_);
    const int row = static_cast<int>((v + 0.5 * other.height_m_) / other.texel_m_);
    return other.texel(std::clamp(column, 0, other.columns_ - 1), std::clamp(row, 0, other.rows_ - 1));
  });
}

void Canvas::darken_edges(double depth_m, double by) {
  each([&](double x, double y, Reflectance c) {
    const double edge = std::min(std::min(x, width_m_ - x), std::min(y, height_m_ - y));
    return (1.0 - by * std::exp(-edge / depth_m)) * c;
  });
}

}  // namespace saccade
