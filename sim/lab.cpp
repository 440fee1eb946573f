#include "sim/lab.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

constexpr double floor_m = -0.62;
constexpr double ceiling_m = 1.95;
constexpr double side_m = 1.9;  // of the walls left and right
constexpr double rear_m = 1.7;  // of the wall behind the robot
constexpr double pi = std::numbers::pi;

/// Random numbers one after the other.
class Dice {
 public:
  Dice(std::uint64_t seed, std::string_view name) : random_(seed, name) {}
  double real(double low, double high) { return random_.uniform(low, high, 0, count_++); }
  int index(int n) { return static_cast<int>(real(0.0, n)); }
  bool chance(double p) { return real(0.0, 1.0) < p; }
  double normal() { return random_.normal(0, count_++); }

 private:
  RandomStream random_;
  std::uint64_t count_ = 0;
};

/// Linear reflectance.
struct Colour {
  double r = 0.0;
  double g = 0.0;
  double b = 0.0;

  friend Colour operator*(double s, Colour c) { return {s * c.r, s * c.g, s * c.b}; }
  friend Colour operator+(Colour a, Colour b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
};
Colour mix(Colour a, Colour b, double t) { return (1.0 - t) * a + t * b; }
Colour grey(double v) { return {v, v, v}; }

/// Smooth noise: random values on a lattice, and sums of it over scales.
class Noise {
 public:
  explicit Noise(Dice& dice) {
    for (float& v : lattice_) v = static_cast<float>(dice.real(-1.0, 1.0));
  }
  /// In [-1, 1], one feature per unit.
  double at(double x, double y) const {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const double u = smooth(x - fx);
    const double v = smooth(y - fy);
    const auto ix = static_cast<std::int64_t>(fx);
    const auto iy = static_cast<std::int64_t>(fy);
    const double top = value(ix, iy) * (1.0 - u) + value(ix + 1, iy) * u;
    const double bottom = value(ix, iy + 1) * (1.0 - u) + value(ix + 1, iy + 1) * u;
    return top * (1.0 - v) + bottom * v;
  }
  /// Each octave is twice as fine and `falloff` as strong: 0.5 looks like clouds, 0.7 like gravel.
  double sum(double x, double y, int octaves, double falloff = 0.6) const {
    double total = 0.0;
    double strength = 1.0;
    double norm = 0.0;
    for (int i = 0; i < octaves; ++i) {
      total += strength * at(x + 17.3 * i, y - 9.1 * i);
      norm += strength * strength;
      strength *= falloff;
      x *= 2.03;
      y *= 2.03;
    }
    return total / std::sqrt(norm);
  }

 private:
  static constexpr std::int64_t side = 64;
  static double smooth(double t) { return t * t * (3.0 - 2.0 * t); }
  double value(std::int64_t x, std::int64_t y) const {
    return static_cast<double>(
        lattice_[static_cast<std::size_t>((y & (side - 1)) * side + (x & (side - 1)))]);
  }

  std::array<float, side * side> lattice_{};
};

/// A surface to paint on, in metres: (0, 0) is its top left corner, x to the right, y down.
class Canvas {
 public:
  Canvas(double width_m, double height_m, int columns, int rows)
      : width_m_(width_m),
        height_m_(height_m),
        columns_(columns),
        rows_(rows),
        texel_m_(width_m / columns),
        pixels_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

  double width() const { return width_m_; }
  double height() const { return height_m_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Colour& texel(int column, int row) {
    return pixels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(column)];
  }

  /// colour = f(x, y, old colour) everywhere.
  template <class F>
  void each(F f) {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        Colour& c = texel(column, row);
        c = f((column + 0.5) * texel_m_, (row + 0.5) * texel_m_, c);
      }
    }
  }
  void fill(Colour colour) { std::fill(pixels_.begin(), pixels_.end(), colour); }

  /// A shape in its own frame (u along, v across, turned by `angle_rad`): inside(u, v) is the distance
  /// inside its border, m; colour(u, v) its paint.
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
  void rectangle(double x, double y, double width, double height, Colour colour) {
    tilted(x + 0.5 * width, y + 0.5 * height, width, height, 0.0,
           [colour](double, double) { return colour; });
  }
  template <class Paint>
  void tilted(double x, double y, double width, double height, double angle_rad, Paint paint) {
    shape(
        x, y, 0.5 * std::hypot(width, height), angle_rad,
        [=](double u, double v) { return std::min(0.5 * width - std::abs(u), 0.5 * height - std::abs(v)); },
        paint);
  }
  /// Pointed at both ends, with a midrib that is a little brighter.
  void leaf(double x, double y, double length, double width, double angle_rad, Colour colour) {
    const double half = 0.5 * length;
    shape(
        x, y, half, angle_rad,
        [=](double u, double v) { return 0.5 * width * (1.0 - (u / half) * (u / half)) - std::abs(v); },
        [=](double u, double v) {
          const double side = 0.85 + 0.3 * std::clamp(v / width + 0.5, 0.0, 1.0) + 0.1 * u / half;
          return (std::abs(v) < 0.05 * width ? 1.25 : side) * colour;
        });
  }
  /// Another canvas, laid on and turned.
  void lay(Canvas& picture, double x, double y, double angle_rad) {
    tilted(x, y, picture.width(), picture.height(), angle_rad, [&picture](double u, double v) {
      const int column = static_cast<int>((u + 0.5 * picture.width_m_) / picture.texel_m_);
      const int row = static_cast<int>((v + 0.5 * picture.height_m_) / picture.texel_m_);
      return picture.texel(std::clamp(column, 0, picture.columns_ - 1),
                           std::clamp(row, 0, picture.rows_ - 1));
    });
  }
  /// Corners and edges of a room are darker.
  void darken_edges(double depth_m, double by) {
    each([&](double x, double y, Colour c) {
      const double edge = std::min(std::min(x, width_m_ - x), std::min(y, height_m_ - y));
      return (1.0 - by * std::exp(-edge / depth_m)) * c;
    });
  }

 private:
  double width_m_;
  double height_m_;
  int columns_;
  int rows_;
  double texel_m_;
  std::vector<Colour> pixels_;
};

using Painter = std::function<void(Canvas&, Dice&)>;

// ------------------------------------------------------------------------------------- surfaces

Colour any_colour(Dice& dice, double low, double high) {
  const double v = dice.real(low, high);
  return {v * dice.real(0.75, 1.35), v * dice.real(0.85, 1.15), v * dice.real(0.6, 1.25)};
}

/// Multiplies by exp(strength * noise): reflectance varies by ratios, as in life.
void roughen(Canvas& canvas, Dice& dice, double feature_m, double strength, int octaves, double falloff = 0.6,
             double stretch = 1.0) {
  const Noise noise(dice);
  const double offset = dice.real(0.0, 60.0);
  canvas.each([&](double x, double y, Colour c) {
    return std::exp(strength *
                    noise.sum(offset + x / feature_m, y / (feature_m * stretch), octaves, falloff)) *
           c;
  });
}

/// Leaves over leaves, large ones first; `tone` spreads their brightness (log).
void scatter_leaves(Canvas& canvas, Dice& dice, double per_m2, double small_m, double large_m, Colour colour,
                    double tone) {
  const int count = static_cast<int>(per_m2 * canvas.width() * canvas.height());
  for (int i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / std::max(count - 1, 1);
    const double length = large_m * std::pow(small_m / large_m, t) * dice.real(0.7, 1.3);
    const double hue = dice.real(-0.25, 0.25);
    const Colour c = std::exp(tone * std::clamp(dice.normal(), -1.8, 1.8)) *
                     Colour{colour.r * (1.0 + hue), colour.g, colour.b * (1.0 - hue)};
    const double x = dice.real(0.0, canvas.width());
    const double y = dice.real(0.0, canvas.height());
    const double width = length * dice.real(0.3, 0.6);
    canvas.leaf(x, y, length, width, dice.real(0.0, 2.0 * pi), c);
  }
}

void text_lines(Canvas& canvas, Dice& dice, double x, double y, double width, double height, double pitch_m,
                Colour ink) {
  for (double at = y; at + 0.5 * pitch_m < y + height; at += pitch_m) {
    const double end = dice.chance(0.2) ? dice.real(0.3, 0.8) : 1.0;
    double word = x;
    while (word < x + end * width) {
      const double length = std::min(pitch_m * dice.real(0.8, 3.5), x + end * width - word);
      canvas.rectangle(word, at, length, 0.5 * pitch_m, ink);
      word += length + 0.6 * pitch_m;
    }
  }
}

void paint_wall_panels(Canvas& canvas, Dice& dice) {
  canvas.fill(grey(0.4));
  const double panel = dice.real(0.5, 0.75);
  for (double x = -dice.real(0.0, panel); x < canvas.width(); x += panel) {
    canvas.rectangle(x, 0.0, panel, canvas.height(), dice.real(0.36, 0.5) * Colour{1.0, 0.98, 0.92});
    canvas.rectangle(x, 0.0, 0.014, canvas.height(), grey(0.2));
  }
  const double rail = canvas.height() - 0.85;
  canvas.rectangle(0.0, rail, canvas.width(), 0.07, grey(0.6));
  canvas.rectangle(0.0, rail + 0.07, canvas.width(), 0.015, grey(0.2));
  canvas.rectangle(0.0, canvas.height() - 0.1, canvas.width(), 0.1, {0.2, 0.17, 0.14});
  for (double x = dice.real(0.1, 0.5); x < canvas.width(); x += dice.real(0.4, 0.9)) {
    canvas.rectangle(x, rail + 0.01, 0.08, 0.05, grey(0.75));  // sockets in the cable duct
    canvas.rectangle(x + 0.02, rail + 0.02, 0.04, 0.03, grey(0.25));
  }
  for (double x = dice.real(0.3, 0.9); x < canvas.width(); x += dice.real(0.7, 1.5)) {
    canvas.rectangle(x, 0.0, 0.025, rail, grey(0.58));  // conduits
    canvas.rectangle(x + 0.025, 0.0, 0.01, rail, grey(0.24));
  }
  roughen(canvas, dice, 0.3, 0.05, 4);
  canvas.darken_edges(0.25, 0.25);
}

void paint_brick(Canvas& canvas, Dice& dice) {
  const double height = dice.real(0.07, 0.1);
  const double length = 2.6 * height;
  const Colour clay = {0.46, 0.34, 0.27};
  canvas.fill({0.52, 0.5, 0.46});
  int course = 0;
  for (double y = 0.0; y < canvas.height(); y += height, ++course) {
    for (double x = -length * dice.real(0.3, 1.0); x < canvas.width();) {
      const double own = length * dice.real(0.75, 1.2);
      const Colour c = std::exp(0.32 * std::clamp(dice.normal(), -1.8, 1.8)) * clay;
      canvas.tilted(x + 0.5 * own, y + 0.5 * height, own - 0.018, height - 0.016, dice.real(-0.03, 0.03),
                    [c, height](double, double v) { return (1.0 - 0.3 * v / height) * c; });
      x += own;
    }
  }
  roughen(canvas, dice, 0.12, 0.22, 5, 0.75);
  roughen(canvas, dice, 0.9, 0.2, 2);
}

void paint_foliage(Canvas& canvas, Dice& dice) {
  canvas.fill({0.14, 0.16, 0.11});
  scatter_leaves(canvas, dice, 330.0, 0.06, 0.2, {0.29, 0.41, 0.21}, 0.45);
  roughen(canvas, dice, 0.5, 0.15, 3);
}

/// A flowered cloth; `fold_m` > 0 hangs it as a curtain.
void paint_cloth(Canvas& canvas, Dice& dice, double fold_m) {
  const Colour ground = any_colour(dice, 0.3, 0.45);
  canvas.fill(ground);
  scatter_leaves(canvas, dice, 60.0, 0.07, 0.22, any_colour(dice, 0.2, 0.35), 0.35);
  scatter_leaves(canvas, dice, 110.0, 0.03, 0.1, any_colour(dice, 0.45, 0.7), 0.3);
  if (fold_m > 0.0) {
    const Noise noise(dice);
    canvas.each([&](double x, double y, Colour c) {
      const double sway = x + 0.25 * fold_m * noise.at(2.0 * x, 0.8 * y);
      return std::exp(0.4 * std::sin(2.0 * pi * sway / fold_m + 1.5 * noise.at(3.0 * x, 5.0))) * c;
    });
  }
  roughen(canvas, dice, 0.05, 0.15, 3, 0.8);
}

/// A picture that could be a photograph: sky, ground, and things in between.
void paint_picture(Canvas& canvas, Dice& dice) {
  const Noise noise(dice);
  const Colour sky = any_colour(dice, 0.45, 0.75);
  const Colour ground = any_colour(dice, 0.15, 0.3);
  const double horizon = canvas.height() * dice.real(0.3, 0.7);
  const double unit = canvas.width();
  canvas.each([&](double x, double y, Colour) {
    const double edge = horizon + 0.18 * unit * noise.sum(4.0 * x / unit, 3.0, 4);
    const double shade = std::exp(0.35 * noise.sum(5.0 * x / unit, 9.0 * y / unit, 5, 0.7));
    return shade * (y < edge ? sky : ground);
  });
  scatter_leaves(canvas, dice, 14.0 / (canvas.width() * canvas.height()), 0.05 * unit, 0.4 * unit,
                 any_colour(dice, 0.2, 0.5), 0.5);
}

void pin_pictures(Canvas& canvas, Dice& dice, double per_m2) {
  const int count = static_cast<int>(std::lround(per_m2 * canvas.width() * canvas.height()));
  for (int i = 0; i < count; ++i) {
    const double width = dice.real(0.16, 0.42);
    const double height = width * dice.real(0.65, 1.4);
    Canvas picture(width, height, static_cast<int>(130 * width), static_cast<int>(130 * height));
    paint_picture(picture, dice);
    const double x = dice.real(0.0, canvas.width());
    const double y = dice.real(0.1, 0.75) * canvas.height();
    const double angle = dice.real(-0.35, 0.35);
    canvas.tilted(x + 0.015, y + 0.02, width, height, angle, [](double, double) { return grey(0.13); });
    canvas.lay(picture, x, y, angle);
  }
}

void paint_floor_tiles(Canvas& canvas, Dice& dice) {
  const double side = dice.real(0.3, 0.5);
  canvas.fill(grey(0.2));
  for (double y = 0.0; y < canvas.height(); y += side) {
    for (double x = 0.0; x < canvas.width(); x += side) {
      canvas.rectangle(x, y, side - 0.015, side - 0.015, dice.real(0.26, 0.4) * Colour{1.0, 0.95, 0.88});
    }
  }
  roughen(canvas, dice, 0.2, 0.08, 4);
  canvas.darken_edges(0.3, 0.3);
}

void paint_carpet(Canvas& canvas, Dice& dice) {
  canvas.fill(any_colour(dice, 0.24, 0.34));
  scatter_leaves(canvas, dice, 25.0, 0.1, 0.35, any_colour(dice, 0.2, 0.5), 0.4);
  roughen(canvas, dice, 0.08, 0.28, 4, 0.85);
  canvas.darken_edges(0.3, 0.3);
}

void paint_ceiling(Canvas& canvas, Dice& dice, double roughness) {
  canvas.fill(grey(0.6));
  roughen(canvas, dice, 0.15, roughness, 4, 0.8);
  constexpr double side = 0.6;
  for (double y = 0.0; y < canvas.height(); y += side) {
    canvas.rectangle(0.0, y, canvas.width(), 0.025, grey(0.35));
    for (double x = 0.0; x < canvas.width(); x += side) {
      canvas.rectangle(x, y, 0.025, side, grey(0.35));
      if (!dice.chance(0.2)) continue;
      canvas.rectangle(x + 0.05, y + 0.05, side - 0.075, side - 0.075, grey(0.9));
      for (double bar = 0.15; bar < 0.55; bar += 0.1) {
        canvas.rectangle(x + bar, y + 0.05, 0.015, side - 0.075, grey(0.55));
      }
    }
  }
  canvas.darken_edges(0.3, 0.25);
}

// --------------------------------------------------------------------------------------- things

void paint_poster(Canvas& canvas, Dice& dice) {
  const double w = canvas.width();
  const double h = canvas.height();
  const Colour paper = any_colour(dice, 0.55, 0.75);
  const Colour ink = any_colour(dice, 0.12, 0.2);
  canvas.fill(grey(0.16));  // the frame
  canvas.rectangle(0.02, 0.02, w - 0.04, h - 0.04, paper);
  canvas.rectangle(0.04, 0.04, w - 0.08, 0.12 * h, any_colour(dice, 0.15, 0.35));
  text_lines(canvas, dice, 0.06, 0.04 + 0.04 * h, w - 0.14, 0.05 * h, 0.05 * h, grey(0.75));
  const int across = w > 0.5 ? 3 : 2;
  const double cell_w = (w - 0.06) / across;
  const double cell_h = 0.27 * h;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < across; ++column) {
      const double x = 0.045 + column * cell_w;
      const double y = 0.2 * h + row * cell_h;
      const double cw = cell_w - 0.03;
      const double ch = cell_h - 0.02;
      switch (dice.index(4)) {
        case 0:  // a bar chart
          canvas.rectangle(x, y, cw, ch, grey(0.7));
          for (double bar = 0.05; bar < 0.9; bar += 0.17) {
            const double tall = dice.real(0.2, 0.85) * ch;
            canvas.rectangle(x + bar * cw, y + ch - tall, 0.11 * cw, tall, any_colour(dice, 0.15, 0.4));
          }
          break;
        case 1:  // a block diagram
          canvas.rectangle(x, y, cw, ch, any_colour(dice, 0.2, 0.5));
          for (int k = 0; k < 4; ++k) {
            const double block_x = x + dice.real(0.02, 0.6) * cw;
            const double block_y = y + dice.real(0.02, 0.7) * ch;
            canvas.rectangle(block_x, block_y, 0.3 * cw, 0.22 * ch, any_colour(dice, 0.15, 0.7));
          }
          break;
        default:
          text_lines(canvas, dice, x, y, cw, ch, 0.024, ink);
      }
    }
  }
}

void paint_window(Canvas& canvas, Dice& dice) {
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.each([&](double, double y, Colour) { return (0.86 - 0.2 * y / h) * Colour{0.9, 0.97, 1.1}; });
  for (double x = -0.1; x < w; x += dice.real(0.12, 0.3)) {  // houses across the street
    const double wide = dice.real(0.12, 0.35);
    const double top = dice.real(0.3, 0.75) * h;
    const Colour wall = any_colour(dice, 0.25, 0.5);
    canvas.rectangle(x, top, wide, h - top, wall);
    for (double y = top + 0.05; y < h; y += 0.1) {
      for (double k = 0.03; k + 0.05 < wide; k += 0.08) canvas.rectangle(x + k, y, 0.045, 0.06, 0.4 * wall);
    }
  }
  const Colour frame = dice.chance(0.5) ? grey(0.35) : Colour{0.22, 0.17, 0.12};
  const int columns = 2 + dice.index(3);
  const int rows = 2 + dice.index(3);
  for (int i = 0; i <= columns; ++i) {
    const double thick = i == 0 || i == columns ? 0.07 : 0.03;
    canvas.rectangle(i * (w - thick) / columns, 0.0, thick, h, frame);
  }
  for (int i = 0; i <= rows; ++i) {
    const double thick = i == 0 || i == rows ? 0.07 : 0.03;
    canvas.rectangle(0.0, i * (h - thick) / rows, w, thick, frame);
  }
}

/// Shelves with the spines of books and binders; above them the dark back.
void paint_books(Canvas& canvas, Dice& dice, int rows) {
  canvas.fill(grey(0.13));
  const double pitch = canvas.height() / rows;
  const double h = pitch - 0.03;
  const Colour board = dice.real(0.4, 0.6) * Colour{1.1, 0.95, 0.8};
  for (int row = 0; row < rows; ++row) {
    const double foot = row * pitch + h;
    canvas.rectangle(0.0, foot, canvas.width(), 0.03, board);
    for (double x = 0.0; x < canvas.width();) {
      if (dice.chance(0.06)) {
        x += dice.real(0.03, 0.12);
        continue;
      }
      const bool binder = dice.chance(0.3);
      const double thick = binder ? dice.real(0.055, 0.08) : dice.real(0.02, 0.05);
      const double tall = (binder ? 0.92 : dice.real(0.55, 0.9)) * h;
      const Colour cover = any_colour(dice, 0.12, 0.62);
      const double top = foot - tall;
      canvas.rectangle(x, top, thick - 0.004, tall, cover);
      const Colour label = cover.g > 0.35 ? any_colour(dice, 0.12, 0.2) : grey(0.7);
      if (binder) {
        canvas.rectangle(x + 0.01, top + 0.15 * tall, thick - 0.024, 0.35 * tall, label);
        canvas.rectangle(x + 0.3 * thick, top + 0.75 * tall, 0.3 * thick, 0.08 * tall, grey(0.12));
      } else if (dice.chance(0.7)) {
        const double band = dice.real(0.05, 0.25) * tall;
        canvas.rectangle(x, top + dice.real(0.1, 0.3) * tall, thick - 0.004, band, label);
      }
      x += thick;
    }
  }
}

void paint_door(Canvas& canvas, Dice& dice) {
  const double w = canvas.width();
  const double h = canvas.height();
  const Colour wood = any_colour(dice, 0.25, 0.5);
  canvas.fill(grey(0.7));
  canvas.rectangle(0.06, 0.06, w - 0.12, h, wood);
  for (const double y : {0.12, 0.5}) {
    canvas.rectangle(0.16, y * h, w - 0.32, 0.34 * h, 0.6 * wood);
    canvas.rectangle(0.18, y * h + 0.02, w - 0.36, 0.34 * h - 0.04, 1.15 * wood);
  }
  canvas.rectangle(w - 0.15, 0.5 * h, 0.06, 0.12, grey(0.75));
}

void paint_whiteboard(Canvas& canvas, Dice& dice) {
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.fill(grey(0.3));
  canvas.rectangle(0.025, 0.025, w - 0.05, h - 0.05, grey(0.72));
  for (int i = 0; i < 9; ++i) {
    const double x = dice.real(0.05, 0.8) * w;
    const double y = dice.real(0.06, 0.75) * h;
    const Colour pen = any_colour(dice, 0.1, 0.2);
    if (dice.chance(0.5)) {
      text_lines(canvas, dice, x, y, 0.2 * w, 0.2 * h, 0.04, pen);
    } else {
      const double bw = dice.real(0.1, 0.2) * w;
      const double bh = dice.real(0.1, 0.2) * h;
      canvas.rectangle(x, y, bw, bh, pen);
      canvas.rectangle(x + 0.012, y + 0.012, bw - 0.024, bh - 0.024, grey(0.7));
      canvas.rectangle(x + bw, y + 0.5 * bh, 0.12 * w, 0.012, pen);
    }
  }
}

void paint_drawers(Canvas& canvas, Dice& dice) {
  const Colour body = any_colour(dice, 0.3, 0.55);
  const int rows = 2 + dice.index(4);
  const double h = canvas.height() / rows;
  canvas.fill(0.35 * body);
  for (int i = 0; i < rows; ++i) {
    canvas.rectangle(0.012, i * h + 0.012, canvas.width() - 0.024, h - 0.018, body);
    canvas.rectangle(0.35 * canvas.width(), i * h + 0.25 * h, 0.3 * canvas.width(), 0.1 * h, grey(0.16));
  }
}

void paint_carton(Canvas& canvas, Dice& dice) {
  const Colour card = dice.real(0.7, 1.3) * Colour{0.38, 0.29, 0.2};
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.fill(0.6 * card);
  canvas.rectangle(0.012, 0.012, w - 0.024, h - 0.024, card);
  canvas.rectangle(0.42 * w, 0.0, 0.16 * w, h, grey(0.55));
  canvas.rectangle(0.08 * w, 0.45 * h, 0.3 * w, 0.3 * h, grey(0.68));
  text_lines(canvas, dice, 0.1 * w, 0.5 * h, 0.25 * w, 0.2 * h, 0.03, grey(0.12));
}

void paint_screen(Canvas& canvas, Dice& dice) {
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.fill(grey(0.12));
  canvas.rectangle(0.02, 0.02, w - 0.04, h - 0.05, {0.16, 0.24, 0.36});
  for (int i = 0; i < 3; ++i) {
    const double x = dice.real(0.05, 0.4) * w;
    const double y = dice.real(0.08, 0.35) * h;
    const double ww = dice.real(0.35, 0.5) * w;
    const double hh = dice.real(0.35, 0.5) * h;
    const bool dark = dice.chance(0.4);
    canvas.rectangle(x, y, ww, hh, grey(dark ? 0.13 : 0.72));
    canvas.rectangle(x, y, ww, 0.02, any_colour(dice, 0.3, 0.5));
    text_lines(canvas, dice, x + 0.01, y + 0.035, ww - 0.03, hh - 0.05, 0.022, grey(dark ? 0.6 : 0.16));
  }
}

void paint_desk(Canvas& canvas, Dice& dice) {
  canvas.fill({0.42, 0.33, 0.24});
  roughen(canvas, dice, 0.03, 0.12, 3, 0.6, 25.0);
  for (int i = 0; i < 10; ++i) {
    const double x = dice.real(0.0, 0.9) * canvas.width();
    const double y = dice.real(0.0, 0.8) * canvas.height();
    canvas.rectangle(x, y, 0.21, 0.15, any_colour(dice, 0.2, 0.7));
    text_lines(canvas, dice, x + 0.02, y + 0.02, 0.16, 0.11, 0.022, grey(0.2));
  }
}

void paint_board(Canvas& canvas, Dice& dice) {
  canvas.fill(dice.real(0.3, 0.5) * Colour{1.1, 0.95, 0.8});
  roughen(canvas, dice, 0.1, 0.05, 3);
}

/// Anything small with a rough coat: a pot, a stone, a cushion.
void paint_rough(Canvas& canvas, Dice& dice) {
  canvas.fill(any_colour(dice, 0.22, 0.5));
  roughen(canvas, dice, 0.12, 0.4, 5, 0.75);
}

// --------------------------------------------------------------------------------------- layout

using Eigen::Vector3d;

/// Where the painted face of a thing looks.
enum class Facing { back_wall, left_wall, right_wall, rear_wall, up, down };

/// The thing's own axes (x right, y up, z out of the painted face) as columns, in the root frame.
Eigen::Matrix3d axes_of(Facing facing) {
  Vector3d right = Vector3d::UnitY();
  Vector3d up = Vector3d::UnitZ();
  switch (facing) {
    case Facing::back_wall:
      break;
    case Facing::left_wall:
      right = -Vector3d::UnitX();
      break;
    case Facing::right_wall:
      right = Vector3d::UnitX();
      break;
    case Facing::rear_wall:
      right = -Vector3d::UnitY();
      break;
    case Facing::up:
      up = -Vector3d::UnitX();
      break;
    case Facing::down:
      up = Vector3d::UnitX();
      break;
  }
  Eigen::Matrix3d axes;
  axes << right, up, right.cross(up);
  return axes;
}

/// A picture and its place in the one texture that holds them all.
struct LabPicture {
  int columns = 0;
  int rows = 0;
  double width_m = 0.0;
  double height_m = 0.0;
  Painter paint;
  int left = 0;
  int top = 0;
};

/// A corner of a triangle: where it is, where it looks, and where in its picture it is (0 to 1, y down).
struct Corner {
  Vector3d point_m;
  Vector3d normal;
  double u = 0.0;
  double v = 0.0;
};

struct Triangle {
  std::array<Corner, 3> corners;  // counterclockwise from outside
  std::size_t picture = 0;
};

/// A point on a wall: metres to the viewer's right along it, height, and distance into the room.
struct Spot {
  double along_m = 0.0;
  double height_m = 0.0;
  double out_m = 0.0;
};

class Lab {
 public:
  Lab(const LabConfig& config, std::uint64_t seed)
      : config_(config), seed_(seed), dice_(seed, "lab layout"), back_m_(-config.wall_distance_m) {
    if (config.clutter == "rectilinear") {
      furnish_rectilinear();
    } else {
      furnish_textured();
    }
    arrange_pictures();
  }

  const std::vector<LabPicture>& pictures() const { return pictures_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// Of the texture that holds all pictures.
  static constexpr int columns = 2048;
  int rows() const { return rows_; }

  void paint(std::size_t index, mjtByte* rgb) const {
    const LabPicture& picture = pictures_[index];
    Canvas canvas(picture.width_m, picture.height_m, picture.columns, picture.rows);
    Dice dice(seed_ * 1000003U + index, "lab picture");
    picture.paint(canvas, dice);
    const auto byte_of = [this](double reflectance) {
      constexpr double middle = 0.33;
      const double v = middle * std::pow(std::max(reflectance, 1e-3) / middle, config_.contrast);
      return static_cast<mjtByte>(std::lround(255.0 * std::clamp(v, 0.09, 0.92)));
    };
    // With a rim of its own outermost texels: interpolation looks half a texel beyond.
    for (int row = -rim; row < picture.rows + rim; ++row) {
      for (int column = -rim; column < picture.columns + rim; ++column) {
        const Colour& c =
            canvas.texel(std::clamp(column, 0, picture.columns - 1), std::clamp(row, 0, picture.rows - 1));
        mjtByte* texel =
            rgb + 3 * ((picture.top + row) * static_cast<std::ptrdiff_t>(columns) + picture.left + column);
        texel[0] = byte_of(c.r);
        texel[1] = byte_of(c.g);
        texel[2] = byte_of(c.b);
      }
    }
  }

 private:
  int several(double at_density_1) const {
    return static_cast<int>(std::lround(at_density_1 * config_.density));
  }
  double back_width() const { return 2.0 * side_m; }
  double side_length() const { return rear_m - back_m_; }
  double height() const { return ceiling_m - floor_m; }

  static constexpr int rim = 2;  // texels around a picture

  std::size_t add_picture(double width_m, double height_m, double texels_per_m, Painter paint) {
    const auto texels = [&](double m) { return std::clamp(static_cast<int>(m * texels_per_m), 16, 640); };
    pictures_.push_back({texels(width_m), texels(height_m), width_m, height_m, std::move(paint)});
    return pictures_.size() - 1;
  }

  /// Side by side in rows, the tallest first.
  void arrange_pictures() {
    std::vector<LabPicture*> order;
    for (LabPicture& picture : pictures_) order.push_back(&picture);
    std::stable_sort(order.begin(), order.end(),
                     [](const auto* a, const auto* b) { return a->rows > b->rows; });
    int left = 0;
    int top = 0;
    for (LabPicture* picture : order) {
      if (left + picture->columns + 2 * rim > columns) {
        left = 0;
        top = rows_;
      }
      picture->left = left + rim;
      picture->top = top + rim;
      left += picture->columns + 2 * rim;
      rows_ = std::max(rows_, top + picture->rows + 2 * rim);
    }
  }

  /// Where a spot is in the room.
  Vector3d place(Facing wall, Spot s) const {
    const double middle_x = 0.5 * (rear_m + back_m_);
    switch (wall) {
      case Facing::left_wall:
        return {middle_x - s.along_m, -side_m + s.out_m, s.height_m};
      case Facing::right_wall:
        return {middle_x + s.along_m, side_m - s.out_m, s.height_m};
      case Facing::rear_wall:
        return {rear_m - s.out_m, -s.along_m, s.height_m};
      default:
        return {back_m_ + s.out_m, s.along_m, s.height_m};
    }
  }

  /// Six faces, each with the whole picture.
  void solid(Vector3d centre_m, std::array<double, 3> half_m, std::size_t picture,
             Facing facing = Facing::back_wall) {
    const Eigen::Matrix3d axes = axes_of(facing);
    const auto face = [&](Vector3d right, Vector3d up) {
      const Vector3d out = right.cross(up);
      const Vector3d half(half_m[0], half_m[1], half_m[2]);
      const auto corner = [&](double x, double y) {
        return Corner{centre_m + axes * half.cwiseProduct(out + x * right + y * up), axes * out,
                      0.5 + 0.5 * x, 0.5 - 0.5 * y};
      };
      triangles_.push_back({{corner(-1, -1), corner(1, -1), corner(1, 1)}, picture});
      triangles_.push_back({{corner(-1, -1), corner(1, 1), corner(-1, 1)}, picture});
    };
    const Vector3d x = Vector3d::UnitX();
    const Vector3d y = Vector3d::UnitY();
    const Vector3d z = Vector3d::UnitZ();
    face(x, y);
    face(-z, y);
    face(z, y);
    face(x, -z);
    face(x, z);
    face(-x, y);
    ++things_;
  }
  /// A box against a wall, `depth_m` deep, its painted face towards the room.
  void box(Facing wall, Spot spot, double width_m, double height_m, double depth_m, std::size_t picture) {
    spot.out_m += 0.5 * depth_m;
    solid(place(wall, spot), {0.5 * width_m, 0.5 * height_m, 0.5 * depth_m}, picture, wall);
  }
  void panel(Facing wall, Spot spot, double width_m, double height_m, double texels_per_m, Painter paint) {
    // Where two overlap, one is in front.
    const double thickness_m = 0.015 + 0.004 * (things_ % 8);
    box(wall, spot, width_m, height_m, thickness_m,
        add_picture(width_m, height_m, texels_per_m, std::move(paint)));
  }
  void poster(Facing wall, Spot spot) {
    const double width_m = dice_.real(0.42, 0.56);
    panel(wall, spot, width_m, width_m * dice_.real(1.2, 1.35), 170.0, paint_poster);
  }
  /// An ellipsoid whose corners are moved in and out by `spikes` of its size, with flat facets.
  void lump(Vector3d centre_m, Vector3d half_m, double spikes, std::size_t picture) {
    constexpr int slices = 12;
    constexpr int stacks = 6;
    std::array<std::array<Vector3d, slices>, stacks + 1> points;
    for (int stack = 0; stack <= stacks; ++stack) {
      for (int slice = 0; slice < slices; ++slice) {
        const double polar = pi * stack / stacks;
        const double around = 2.0 * pi * slice / slices;
        const bool pole = stack == 0 || stack == stacks;
        const Vector3d direction(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                 std::cos(polar));
        const double r = 1.0 + (pole ? 0.0 : spikes * dice_.real(-1.0, 1.0));
        points[static_cast<std::size_t>(stack)][static_cast<std::size_t>(slice)] =
            centre_m + r * half_m.cwiseProduct(direction);
      }
    }
    const auto corner = [&](int stack, int slice) {
      return Corner{points[static_cast<std::size_t>(stack)][static_cast<std::size_t>(slice % slices)],
                    Vector3d::Zero(), static_cast<double>(slice) / slices,
                    static_cast<double>(stack) / stacks};
    };
    const auto facet = [&](Corner a, Corner b, Corner c) {
      a.normal = b.normal = c.normal = (b.point_m - a.point_m).cross(c.point_m - a.point_m).normalized();
      triangles_.push_back({{a, b, c}, picture});
    };
    for (int stack = 0; stack < stacks; ++stack) {
      for (int slice = 0; slice < slices; ++slice) {
        if (stack + 1 < stacks)
          facet(corner(stack, slice), corner(stack + 1, slice), corner(stack + 1, slice + 1));
        if (stack > 0) facet(corner(stack, slice), corner(stack + 1, slice + 1), corner(stack, slice + 1));
      }
    }
  }

  void shell(Painter back, Painter left, Painter right, Painter rear, Painter floor, Painter ceiling) {
    const double middle_x = 0.5 * (rear_m + back_m_);
    const double middle_z = 0.5 * (ceiling_m + floor_m);
    // Outside the room, so that the painted faces are its inside.
    const auto wall = [&](Facing facing, double width_m, Painter paint) {
      box(facing, {0.0, middle_z, -0.1}, width_m, height(), 0.1,
          add_picture(width_m, height(), 125.0, std::move(paint)));
    };
    wall(Facing::back_wall, back_width(), std::move(back));
    wall(Facing::left_wall, side_length(), std::move(left));
    wall(Facing::right_wall, side_length(), std::move(right));
    wall(Facing::rear_wall, back_width(), std::move(rear));
    const std::array<double, 3> slab{side_m, 0.5 * side_length(), 0.05};
    solid({middle_x, 0.0, floor_m - 0.05}, slab,
          add_picture(back_width(), side_length(), 100.0, std::move(floor)), Facing::up);
    solid({middle_x, 0.0, ceiling_m + 0.05}, slab,
          add_picture(back_width(), side_length(), 80.0, std::move(ceiling)), Facing::down);
  }

  /// A table between the robot's reach and the wall. Returns the height of its top.
  double table(Painter top, Painter front) {
    constexpr double depth = 0.6;
    const double width = dice_.real(1.5, 1.9);
    const double height = dice_.real(-0.12, -0.02);
    table_x_ = back_m_ + dice_.real(0.75, 0.95);
    table_width_ = width;
    solid({table_x_, 0.0, height - 0.02}, {0.5 * width, 0.5 * depth, 0.02},
          add_picture(width, depth, 150.0, std::move(top)), Facing::up);
    const double drop = height - 0.04 - floor_m;
    solid({table_x_ + 0.5 * depth - 0.03, 0.0, floor_m + 0.5 * drop}, {0.5 * width - 0.02, 0.5 * drop, 0.02},
          add_picture(width, drop, 120.0, std::move(front)));
    return height;
  }

  void bookcase(Facing wall, double along_m, double width_m, double foot_m, int rows) {
    const double height_m = 0.36 * rows;
    const double middle = foot_m + 0.5 * height_m;
    box(wall, {along_m, middle, 0.0}, width_m, height_m, 0.2,
        add_picture(width_m, height_m, 150.0, [rows](Canvas& c, Dice& d) { paint_books(c, d, rows); }));
    const std::size_t board = add_picture(0.25, 0.25, 128.0, paint_board);
    box(wall, {along_m, foot_m + height_m + 0.015, 0.0}, width_m + 0.06, 0.03, 0.26, board);
    for (const double side : {-0.5, 0.5}) {
      box(wall, {along_m + side * (width_m + 0.03), middle, 0.0}, 0.03, height_m, 0.26, board);
    }
  }

  void furnish_rectilinear() {
    const double z = table(paint_desk, paint_drawers);
    for (int i = 0; i < several(4); ++i) {  // on the table
      const double width = dice_.real(0.12, 0.3);
      const double tall = dice_.real(0.12, 0.32);
      const double y = table_width_ * (dice_.real(-0.12, 0.12) + 0.78 * ((i + 0.5) / several(4) - 0.5));
      solid({table_x_ - dice_.real(0.0, 0.12), y, z + 0.5 * tall}, {0.5 * width, 0.5 * tall, 0.5 * width},
            add_picture(width, width, 200.0, paint_carton));
    }
    const double y = dice_.real(-0.35, 0.35);
    solid({table_x_ - 0.1, y, z + 0.3}, {0.29, 0.18, 0.02}, add_picture(0.58, 0.36, 180.0, paint_screen));
    solid({table_x_ - 0.13, y, z + 0.08}, {0.05, 0.08, 0.02}, add_picture(0.1, 0.16, 120.0, paint_rough));

    const double side = dice_.chance(0.5) ? 1.0 : -1.0;
    const double case_at = side * dice_.real(1.0, 1.2);
    bookcase(Facing::back_wall, case_at, dice_.real(0.9, 1.2), floor_m + 0.25, 5);
    const double window_width = dice_.real(1.0, 1.3);
    const double window_at = -side * dice_.real(0.75, 1.0);
    panel(Facing::back_wall, {window_at, 0.95, 0.0}, window_width, dice_.real(0.95, 1.25), 150.0,
          paint_window);
    const std::array<Spot, 4> back_spots{
        {{side * 0.12, 0.55, 0.0}, {side * 0.1, 1.3, 0.0}, {-side * 1.6, 0.5, 0.0}, {window_at, 0.12, 0.0}}};
    for (int i = 0; i < std::min(several(3), 4); ++i) {
      Spot spot = back_spots[static_cast<std::size_t>(i)];
      spot.along_m += dice_.real(-0.06, 0.06);
      poster(Facing::back_wall, spot);
    }
    // Side walls: one has the window, the other the door.
    const bool door_left = dice_.chance(0.5);
    const Facing door_wall = door_left ? Facing::left_wall : Facing::right_wall;
    const Facing window_wall = door_left ? Facing::right_wall : Facing::left_wall;
    const double ahead = door_left ? 1.0 : -1.0;  // `along` towards the back wall on the door's side
    panel(door_wall, {ahead * 1.2, floor_m + 1.0, 0.0}, 0.95, 2.0, 100.0, paint_door);
    panel(door_wall, {ahead * 0.05, 0.6, 0.0}, 1.1, 0.85, 130.0, paint_whiteboard);
    panel(window_wall, {-ahead * 0.75, 0.85, 0.0}, dice_.real(1.2, 1.5), 1.2, 130.0, paint_window);
    if (several(1) > 0) bookcase(window_wall, ahead * 0.6, 0.9, floor_m + 0.03, 3);
    for (int i = 0; i < std::min(several(2), 4); ++i) {
      poster(i % 2 == 0 ? door_wall : window_wall,
             {ahead * (i % 2 == 0 ? -0.9 : 0.4), i < 2 ? 0.75 : 1.4, 0.0});
    }
    for (int i = 0; i < several(3); ++i) {  // cartons on the floor
      const double size = dice_.real(0.3, 0.5);
      const double at = (i % 2 == 0 ? 1.0 : -1.0) * dice_.real(1.1, 1.5);
      const std::size_t carton =
          add_picture(size, size, 150.0, dice_.chance(0.4) ? paint_drawers : paint_carton);
      solid({back_m_ + dice_.real(0.9, 1.5), at, floor_m + 0.5 * size}, {0.5 * size, 0.5 * size, 0.5 * size},
            carton);
    }
    shell(paint_wall_panels, paint_wall_panels, paint_wall_panels, paint_wall_panels, paint_floor_tiles,
          [](Canvas& c, Dice& d) { paint_ceiling(c, d, 0.05); });
  }

  void plant(double x, double y, double foot_m, double size_m) {
    const double pot_height = 0.45 * size_m;
    solid({x, y, foot_m + 0.5 * pot_height}, {0.2 * size_m, 0.5 * pot_height, 0.2 * size_m},
          add_picture(0.3, 0.3, 150.0, paint_rough));
    const std::size_t leaves = add_picture(2.4 * size_m, 1.2 * size_m, 150.0, paint_foliage);
    for (int i = 0; i < 2; ++i) {
      const Vector3d off{dice_.real(-0.15, 0.15), dice_.real(-0.25, 0.25),
                         0.3 + 0.5 * i + dice_.real(-0.1, 0.1)};
      const Vector3d half{dice_.real(0.35, 0.55), dice_.real(0.35, 0.55), dice_.real(0.4, 0.55)};
      lump(Vector3d(x, y, foot_m + pot_height) + size_m * off, size_m * half, 0.32, leaves);
    }
  }

  void furnish_textured() {
    const auto cloth = [](Canvas& c, Dice& d) { paint_cloth(c, d, 0.0); };
    const double fold_m = dice_.real(0.14, 0.24);
    const Painter curtain = [fold_m](Canvas& c, Dice& d) { paint_cloth(c, d, fold_m); };
    const double z = table(cloth, curtain);
    for (int i = 0; i < several(3); ++i) {  // stones, cushions, pots on the table
      const double y = table_width_ * (dice_.real(-0.1, 0.1) + 0.8 * ((i + 0.5) / several(3) - 0.5));
      const Vector3d half{dice_.real(0.07, 0.12), dice_.real(0.09, 0.17), dice_.real(0.06, 0.13)};
      const std::size_t coat =
          add_picture(0.8, 0.4, 190.0, dice_.chance(0.5) ? Painter(paint_rough) : Painter(cloth));
      lump({table_x_ - dice_.real(0.0, 0.12), y, z + 0.85 * half.z()}, half, 0.12, coat);
    }
    if (several(1) > 0) plant(table_x_ - 0.1, dice_.real(-0.6, 0.6), z, 0.3);
    for (int i = 0; i < several(2); ++i) {
      const double x = back_m_ + dice_.real(0.5, 0.9);
      const double y = (i % 2 == 0 ? 1.0 : -1.0) * dice_.real(1.2, 1.5);
      plant(x, y, floor_m, dice_.real(0.6, 0.85));
    }
    for (int i = 0; i < several(2); ++i) {
      const Facing wall = i % 2 == 0 ? Facing::left_wall : Facing::right_wall;
      const Spot spot{dice_.real(-0.9, 0.9), dice_.real(0.3, 1.0), 0.0};
      const double width_m = dice_.real(0.5, 0.9);
      panel(wall, spot, width_m, width_m * dice_.real(0.7, 1.3), 150.0, [](Canvas& c, Dice& d) {
        paint_cloth(c, d, 0.0);
        pin_pictures(c, d, 6.0);
      });
    }
    const double pictures = 2.4 * config_.density;
    const Painter brick = [pictures](Canvas& c, Dice& d) {
      paint_brick(c, d);
      pin_pictures(c, d, pictures);
      c.darken_edges(0.25, 0.25);
    };
    const Painter plaster = [pictures](Canvas& c, Dice& d) {
      c.fill({0.43, 0.39, 0.34});
      roughen(c, d, 0.35, 0.3, 6, 0.72);
      scatter_leaves(c, d, 70.0, 0.05, 0.16, {0.26, 0.34, 0.18}, 0.4);
      pin_pictures(c, d, pictures);
      c.darken_edges(0.25, 0.25);
    };
    const Painter ivy = [](Canvas& c, Dice& d) {
      paint_foliage(c, d);
      c.darken_edges(0.25, 0.25);
    };
    std::array<Painter, 4> walls{brick, plaster, curtain, ivy};
    // The wall in front is brick or plaster; the others follow in a random order.
    if (dice_.chance(0.5)) std::swap(walls[0], walls[1]);
    for (std::size_t i = 3; i > 1; --i)
      std::swap(walls[i], walls[1 + static_cast<std::size_t>(dice_.index(static_cast<int>(i)))]);
    shell(walls[0], walls[1], walls[2], walls[3], paint_carpet,
          [](Canvas& c, Dice& d) { paint_ceiling(c, d, 0.25); });
  }

  const LabConfig& config_;
  std::uint64_t seed_;
  Dice dice_;
  double back_m_;
  double table_x_ = 0.0;
  double table_width_ = 0.0;
  int things_ = 0;
  int rows_ = 0;
  std::vector<LabPicture> pictures_;
  std::vector<Triangle> triangles_;
};

/// printf into a string.
template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 512> text{};
  const int length = std::snprintf(text.data(), text.size(), format, values...);
  SACCADE_CHECK(length >= 0 && length < static_cast<int>(text.size()));
  return text.data();
}

}  // namespace

void describe(FieldVisitor& v, LabConfig& config) {
  v.choice("clutter", config.clutter, {"textured", "rectilinear"}, "what the lab is full of");
  v.real("density", config.density, {0.0, 2.0}, "how many things stand, hang and lie about");
  v.real("contrast", config.contrast, {0.0, 1.5}, "of everything painted: 0 flat grey, 1 as in life");
  v.real("brightness", config.brightness, {0.3, 1.2}, "of the light");
  v.real("wall_distance_m", config.wall_distance_m, {1.8, 4.0}, "from the waist to the wall in front");
}

std::string lab_mjcf(const LabConfig& config, std::uint64_t seed) {
  check_config("lab", config);
  const Lab lab(config, seed);
  std::string points;
  std::string normals;
  std::string texels;
  std::string faces;
  int count = 0;
  for (const Triangle& triangle : lab.triangles()) {
    const LabPicture& picture = lab.pictures()[triangle.picture];
    for (const Corner& c : triangle.corners) {
      points += print("%.4f %.4f %.4f ", c.point_m.x(), c.point_m.y(), c.point_m.z());
      normals += print("%.4f %.4f %.4f ", c.normal.x(), c.normal.y(), c.normal.z());
      texels += print("%.6f %.6f ", (picture.left + c.u * picture.columns) / Lab::columns,
                      (picture.top + c.v * picture.rows) / lab.rows());
    }
    faces += print("%d %d %d ", count, count + 1, count + 2);
    count += 3;
  }
  std::string bodies;
  const auto light = [&](const char* name, const char* direction, double ambient, double diffuse) {
    bodies += print(
        "  <light name=\"lab_%s\" directional=\"true\" dir=\"%s\" pos=\"%s\" ambient=\"%.4f %.4f %.4f\" "
        "diffuse=\"%.4f %.4f %.4f\" specular=\"0 0 0\" castshadow=\"false\"/>\n",
        name, direction, "0.6 0.4 1.8", ambient, ambient, ambient, diffuse, diffuse, diffuse);
  };
  light("lamp", "-0.55 -0.35 -0.76", 0.4 * config.brightness, 0.5 * config.brightness);
  light("sky", "-0.35 0.9 -0.25", 0.0, 0.35 * config.brightness);
  return print(
             "<asset>\n"
             "  <texture name=\"lab\" type=\"2d\" builtin=\"flat\" width=\"%d\" height=\"%d\" rgb1=\"0.33 "
             "0.33 0.33\"/>\n"
             "  <material name=\"lab\" texture=\"lab\" specular=\"0\" shininess=\"0\"/>\n",
             Lab::columns, lab.rows()) +
         "  <mesh name=\"lab\" vertex=\"" + points + "\" normal=\"" + normals + "\" texcoord=\"" + texels +
         "\" face=\"" + faces + "\"/>\n</asset>\n<worldbody>\n" + bodies +
         "  <geom name=\"lab\" type=\"mesh\" mesh=\"lab\" material=\"lab\" group=\"1\" contype=\"0\" "
         "conaffinity=\"0\"/>\n"
         "</worldbody>\n";
}

void paint_lab_textures(mjModel& model, const LabConfig& config, std::uint64_t seed) {
  check_config("lab", config);
  const Lab lab(config, seed);
  const int id = mj_name2id(&model, mjOBJ_TEXTURE, "lab");
  if (id < 0 || model.tex_width[id] != Lab::columns || model.tex_height[id] != lab.rows()) {
    throw RunError("the model does not hold this lab");
  }
  mjtByte* const rgb = texture_rgb(model, id);
  for (std::size_t i = 0; i < lab.pictures().size(); ++i) lab.paint(i, rgb);
}

}  // namespace saccade
