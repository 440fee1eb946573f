#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/lab_painters.h"
#include "sim/value_noise.h"

namespace saccade::lab {
namespace {

using std::numbers::pi;

}  // namespace

Reflectance any_colour(RandomGenerator& random, double low, double high) {
  const double v = random.real(low, high);
  return {v * random.real(0.75, 1.35), v * random.real(0.85, 1.15), v * random.real(0.6, 1.25)};
}

void roughen(Canvas& canvas, RandomGenerator& random, double feature_m, double strength, int octaves,
             double falloff, double stretch) {
  const ValueNoise noise(random);
  const double offset = random.real(0.0, 60.0);
  canvas.each([&](double x, double y, Reflectance c) {
    return std::exp(strength *
                    noise.sum(offset + x / feature_m, y / (feature_m * stretch), octaves, falloff)) *
           c;
  });
}

void scatter_leaves(Canvas& canvas, RandomGenerator& random, double per_m2, double small_m, double large_m,
                    Reflectance colour, double tone) {
  const int count = static_cast<int>(per_m2 * canvas.width() * canvas.height());
  for (int i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / std::max(count - 1, 1);
    const double length = large_m * std::pow(small_m / large_m, t) * random.real(0.7, 1.3);
    const double hue = random.real(-0.25, 0.25);
    const Reflectance c = std::exp(tone * std::clamp(random.normal(), -1.8, 1.8)) *
                          Reflectance{colour.r * (1.0 + hue), colour.g, colour.b * (1.0 - hue)};
    const double x = random.real(0.0, canvas.width());
    const double y = random.real(0.0, canvas.height());
    const double width = length * random.real(0.3, 0.6);
    canvas.leaf(x, y, length, width, random.real(0.0, 2.0 * pi), c);
  }
}

void paint_wall_panels(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(grey(0.4));
  const double panel = random.real(0.5, 0.75);
  for (double x = -random.real(0.0, panel); x < canvas.width(); x += panel) {
    canvas.rectangle(x, 0.0, panel, canvas.height(), random.real(0.36, 0.5) * Reflectance{1.0, 0.98, 0.92});
    canvas.rectangle(x, 0.0, 0.014, canvas.height(), grey(0.2));
  }
  const double rail = canvas.height() - 0.85;
  canvas.rectangle(0.0, rail, canvas.width(), 0.07, grey(0.6));
  canvas.rectangle(0.0, rail + 0.07, canvas.width(), 0.015, grey(0.2));
  canvas.rectangle(0.0, canvas.height() - 0.1, canvas.width(), 0.1, {0.2, 0.17, 0.14});
  for (double x = random.real(0.1, 0.5); x < canvas.width(); x += random.real(0.4, 0.9)) {
    canvas.rectangle(x, rail + 0.01, 0.08, 0.05, grey(0.75));  // sockets in the cable duct
    canvas.rectangle(x + 0.02, rail + 0.02, 0.04, 0.03, grey(0.25));
  }
  for (double x = random.real(0.3, 0.9); x < canvas.width(); x += random.real(0.7, 1.5)) {
    canvas.rectangle(x, 0.0, 0.025, rail, grey(0.58));  // conduits
    canvas.rectangle(x + 0.025, 0.0, 0.01, rail, grey(0.24));
  }
  roughen(canvas, random, 0.3, 0.05, 4);
  canvas.darken_edges(0.25, 0.25);
}

void paint_brick(Canvas& canvas, RandomGenerator& random) {
  const double height = random.real(0.07, 0.1);
  const double length = 2.6 * height;
  const Reflectance clay = {0.46, 0.34, 0.27};
  canvas.fill({0.52, 0.5, 0.46});
  int layer = 0;
  for (double y = 0.0; y < canvas.height(); y += height, ++layer) {
    for (double x = -length * random.real(0.3, 1.0); x < canvas.width();) {
      const double own = length * random.real(0.75, 1.2);
      const Reflectance c = std::exp(0.32 * std::clamp(random.normal(), -1.8, 1.8)) * clay;
      canvas.tilted(x + 0.5 * own, y + 0.5 * height, own - 0.018, height - 0.016, random.real(-0.03, 0.03),
                    [c, height](double, double v) { return (1.0 - 0.3 * v / height) * c; });
      x += own;
    }
  }
  roughen(canvas, random, 0.12, 0.22, 5, 0.75);
  roughen(canvas, random, 0.9, 0.2, 2);
}

void paint_foliage(Canvas& canvas, RandomGenerator& random) {
  canvas.fill({0.14, 0.16, 0.11});
  scatter_leaves(canvas, random, 330.0, 0.06, 0.2, {0.29, 0.41, 0.21}, 0.45);
  roughen(canvas, random, 0.5, 0.15, 3);
}

/// A flowered cloth; `fold_m` > 0 hangs it as a curtain.
void paint_cloth(Canvas& canvas, RandomGenerator& random, double fold_m) {
  const Reflectance ground = any_colour(random, 0.3, 0.45);
  canvas.fill(ground);
  scatter_leaves(canvas, random, 60.0, 0.07, 0.22, any_colour(random, 0.2, 0.35), 0.35);
  scatter_leaves(canvas, random, 110.0, 0.03, 0.1, any_colour(random, 0.45, 0.7), 0.3);
  if (fold_m > 0.0) {
    const ValueNoise noise(random);
    canvas.each([&](double x, double y, Reflectance c) {
      const double sway = x + 0.25 * fold_m * noise.at(2.0 * x, 0.8 * y);
      return std::exp(0.4 * std::sin(2.0 * pi * sway / fold_m + 1.5 * noise.at(3.0 * x, 5.0))) * c;
    });
  }
  roughen(canvas, random, 0.05, 0.15, 3, 0.8);
}

void paint_natural(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(any_colour(random, 0.25, 0.4));
  // Equal strength in every octave: the amplitude falls with 1/f.
  roughen(canvas, random, random.real(0.5, 1.0), random.real(0.6, 0.9), 7, 1.0);
  if (random.chance(0.5))
    scatter_leaves(canvas, random, 25.0, 0.03, 0.25, any_colour(random, 0.15, 0.5), 0.5);
}

void paint_blinds(Canvas& canvas, RandomGenerator& random, double slat_m, bool upright) {
  const Reflectance slat = any_colour(random, 0.4, 0.65);
  const double dark = random.real(0.25, 0.7);  // of the gap and of the slat's far edge
  const double tilt = random.real(-0.3, 0.3);
  const ValueNoise noise(random);
  canvas.each([&](double x, double y, Reflectance) {
    const double along = upright ? x : y;
    const double at = along / slat_m - std::floor(along / slat_m);
    const double shade = at < 0.14 ? dark : 0.85 + tilt * (at - 0.57);
    return shade * (1.0 + 0.05 * noise.at(4.0 * x, 4.0 * y)) * slat;
  });
  canvas.darken_edges(0.25, 0.25);
}

/// A photograph of a landscape: sky, ground and plants between them.
void paint_photograph(Canvas& canvas, RandomGenerator& random) {
  const ValueNoise noise(random);
  const Reflectance sky = any_colour(random, 0.45, 0.75);
  const Reflectance ground = any_colour(random, 0.15, 0.3);
  const double horizon = canvas.height() * random.real(0.3, 0.7);
  const double unit = canvas.width();
  canvas.each([&](double x, double y, Reflectance) {
    const double edge = horizon + 0.18 * unit * noise.sum(4.0 * x / unit, 3.0, 4);
    const double shade = std::exp(0.35 * noise.sum(5.0 * x / unit, 9.0 * y / unit, 5, 0.7));
    return shade * (y < edge ? sky : ground);
  });
  scatter_leaves(canvas, random, 14.0 / (canvas.width() * canvas.height()), 0.05 * unit, 0.4 * unit,
                 any_colour(random, 0.2, 0.5), 0.5);
}

void pin_photographs(Canvas& canvas, RandomGenerator& random, double per_m2) {
  const int count = static_cast<int>(std::lround(per_m2 * canvas.width() * canvas.height()));
  for (int i = 0; i < count; ++i) {
    const double width = random.real(0.16, 0.42);
    const double height = width * random.real(0.65, 1.4);
    Canvas photograph(width, height, static_cast<int>(130 * width), static_cast<int>(130 * height));
    paint_photograph(photograph, random);
    const double x = random.real(0.0, canvas.width());
    const double y = random.real(0.1, 0.75) * canvas.height();
    const double angle = random.real(-0.35, 0.35);
    canvas.tilted(x + 0.015, y + 0.02, width, height, angle, [](double, double) { return grey(0.13); });
    canvas.lay(photograph, x, y, angle);
  }
}

void paint_floor_tiles(Canvas& canvas, RandomGenerator& random) {
  const double side = random.real(0.3, 0.5);
  canvas.fill(grey(0.2));
  for (double y = 0.0; y < canvas.height(); y += side) {
    for (double x = 0.0; x < canvas.width(); x += side) {
      canvas.rectangle(x, y, side - 0.015, side - 0.015,
                       random.real(0.26, 0.4) * Reflectance{1.0, 0.95, 0.88});
    }
  }
  roughen(canvas, random, 0.2, 0.08, 4);
  canvas.darken_edges(0.3, 0.3);
}

void paint_carpet(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(any_colour(random, 0.24, 0.34));
  scatter_leaves(canvas, random, 25.0, 0.1, 0.35, any_colour(random, 0.2, 0.5), 0.4);
  roughen(canvas, random, 0.08, 0.28, 4, 0.85);
  canvas.darken_edges(0.3, 0.3);
}

void paint_ceiling(Canvas& canvas, RandomGenerator& random, double roughness) {
  canvas.fill(grey(0.6));
  roughen(canvas, random, 0.15, roughness, 4, 0.8);
  constexpr double side = 0.6;
  for (double y = 0.0; y < canvas.height(); y += side) {
    canvas.rectangle(0.0, y, canvas.width(), 0.025, grey(0.35));
    for (double x = 0.0; x < canvas.width(); x += side) {
      canvas.rectangle(x, y, 0.025, side, grey(0.35));
      if (!random.chance(0.2)) continue;
      canvas.rectangle(x + 0.05, y + 0.05, side - 0.075, side - 0.075, grey(0.9));
      for (double bar = 0.15; bar < 0.55; bar += 0.1) {
        canvas.rectangle(x + bar, y + 0.05, 0.015, side - 0.075, grey(0.55));
      }
    }
  }
  canvas.darken_edges(0.3, 0.25);
}
}  // namespace saccade::lab
