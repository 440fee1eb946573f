#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace saccade {

/// Linear reflectance in red, green and blue; 0 black, 1 white.
struct Reflectance {
  double r = 0.0;
  double g = 0.0;
  double b = 0.0;

  friend Reflectance operator*(double s, Reflectance c) { return {s * c.r, s * c.g, s * c.b}; }
  friend Reflectance operator+(Reflectance a, Reflectance b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
};
inline Reflectance mix(Reflectance a, Reflectance b, double t) { return (1.0 - t) * a + t * b; }
inline Reflectance grey(double v) { return {v, v, v}; }

/// A rectangle of texels to paint on, addressed in metres: (0, 0) is its top left corner, x to the right, y down.
class Canvas {
 public:
  Canvas(double width_m, double height_m, int columns, int rows)
      : width_m_(width_m),
        height_m_(height_m),
        columns_(columns),
        rows_(rows),
        texel_m_(width_m / columns),
        pixels_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

  [[nodiscard]] double width() const { return width_m_; }
  [[nodiscard]] double height() const { return height_m_; }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  Reflectance& texel(int column, int row) {
    return pixels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(column)];
  }

  /// Replaces the colour of every texel by f(x, y, old colour).
  template <class F>
  void each(F f) {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        Reflectance& c = texel(column, row);
        c = f((column + 0.5) * texel_m_, (row + 0.5) * texel_m_, c);
      }
    }
  }
  void fill(Reflectance colour) { std::fill(pixels_.begin(), pixels_.end(), colour); }

  /// Paints a shape that is centred at (x, y), turned by angle_rad and lies within reach_m of the centre. In its own
  /// frame, u along and v across, inside(u, v) is the distance inside its border, m, and paint(u, v) its colour.
  template <class Inside, class Paint>
  void shape(double x, double y, double reach_m, double angle_rad, Inside inside, Paint paint) {
    const double c = std::cos(angle_rad);
    const double s = std::sin(angle_rad);
    const int left = std::max(0, static_cast<int>((x - reach_m) / texel_m_) - 1);
    const int right = std::min(columns_ - 1, static_cast<int>((x + reach_m) / texel_m_) + 1);
    const int top = std::max(0, static_cast<int>((y - reach_m) / texel_m_) - 1);
    const int bottom = std::min(rows_ - 1, static_cast<int>((y + reach_m) / texel_m_) + 1);
    for (int row = top; row <= bottom; ++row) {
      for (int column = left; column <= right; ++column) {
        const double dx = (column + 0.5) * texel_m_ - x;
        const double dy = (row + 0.5) * texel_m_ - y;
        const double u = c * dx + s * dy;
        const double v = c * dy - s * dx;
        const double cover = std::clamp(inside(u, v) / texel_m_ + 0.5, 0.0, 1.0);
        if (cover > 0.0) texel(column, row) = mix(texel(column, row), paint(u, v), cover);
      }
    }
  }
  /// An upright rectangle with its top left corner at (x, y).
  void rectangle(double x, double y, double width, double height, Reflectance colour) {
    tilted(x + 0.5 * width, y + 0.5 * height, width, height, 0.0,
           [colour](double, double) { return colour; });
  }
  /// The same for a rectangle centred at (x, y).
  template <class Paint>
  void tilted(double x, double y, double width, double height, double angle_rad, Paint paint) {
    shape(
        x, y, 0.5 * std::hypot(width, height), angle_rad,
        [=](double u, double v) { return std::min(0.5 * width - std::abs(u), 0.5 * height - std::abs(v)); },
        paint);
  }
  /// A leaf: pointed at both ends, with a midrib that is a little brighter.
  void leaf(double x, double y, double length, double width, double angle_rad, Reflectance colour);
  /// Copies another canvas, centred at (x, y) and turned.
  void lay(Canvas& other, double x, double y, double angle_rad);
  /// Darkens the borders, as corners and edges of a room are darker: by the share `by` at the border, and less
  /// with the distance from it in units of depth_m (exponentially).
  void darken_edges(double depth_m, double by);

 private:
  double width_m_;
  double height_m_;
  int columns_;
  int rows_;
  double texel_m_;
  std::vector<Reflectance> pixels_;
};

}  // namespace saccade
