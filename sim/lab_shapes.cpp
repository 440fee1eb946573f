#include "sim/lab_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/random_generator.h"

namespace saccade::lab {
namespace {

using Eigen::Vector2d;
using Outline = std::vector<Vector2d>;  ///< corners around the middle (0, 0), none farther from it than 1

using std::numbers::pi;

Vector2d direction(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

/// Corners at equal angles, at the radius 1 and `other` by turns, narrowed to `height`.
Outline corners(int count, double other, double height) {
  Outline outline;
  for (int i = 0; i < count; ++i) {
    const Vector2d corner = (i % 2 == 0 ? 1.0 : other) * direction(2.0 * pi * i / count);
    outline.emplace_back(corner.x(), height * corner.y());
  }
  return outline;
}

/// A disc from the angle 0 to angle_rad, closed through a point at `depth` from the middle towards the missing part.
Outline part_of_disc(double angle_rad, double depth) {
  constexpr int steps = 32;
  Outline outline;
  for (int i = 0; i <= steps; ++i) outline.push_back(direction(angle_rad * i / steps));
  outline.push_back(-depth * direction(0.5 * angle_rad));
  return outline;
}

Outline any_outline(RandomGenerator& random) {
  switch (random.index(5)) {
    case 0:
      return corners(3 + random.index(4), 1.0, random.real(0.6, 1.0));
    case 1:
      return corners(2 * (4 + random.index(4)), random.real(0.4, 0.65), 1.0);
    case 2:
      return corners(48, 1.0, random.real(0.4, 0.8));
    case 3:
      return part_of_disc(random.real(0.5, 1.2) * pi, random.real(-0.4, 0.1));
    default: {
      const double shaft = random.real(0.2, 0.4);
      return {{0.95, 0.0},    {0.1, 0.8},    {0.1, shaft}, {-0.9, shaft},
              {-0.9, -shaft}, {0.1, -shaft}, {0.1, -0.8}};
    }
  }
}

/// Distance of p inside the outline; negative outside.
double inside_distance(const Outline& outline, const Vector2d& p) {
  double squared = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& a = outline[i];
    const Vector2d& b = outline[(i + 1) % outline.size()];
    const Vector2d side = b - a;
    const Vector2d from = p - a;
    const double along = std::clamp(from.dot(side) / side.squaredNorm(), 0.0, 1.0);
    squared = std::min(squared, (from - along * side).squaredNorm());
    // A ray to the right of p crosses this side.
    const bool left_of_side = from.x() * side.y() < from.y() * side.x();
    if ((a.y() > p.y()) != (b.y() > p.y()) && left_of_side == (side.y() > 0.0)) inside = !inside;
  }
  return inside ? std::sqrt(squared) : -std::sqrt(squared);
}

void paint_shape(Canvas& canvas, RandomGenerator& random) {
  const bool dark = random.chance(0.7);
  canvas.fill(dark ? any_colour(random, 0.5, 0.85) : any_colour(random, 0.05, 0.2));
  const Outline outline = any_outline(random);
  const double middle = 0.5 * canvas.width();
  const double radius = random.real(0.45, 0.9) * middle;
  const Reflectance colour = dark ? any_colour(random, 0.05, 0.2) : any_colour(random, 0.5, 0.85);
  canvas.shape(
      middle, middle, radius, random.real(0.0, 2.0 * pi),
      [&](double u, double v) {
        return radius * inside_distance(outline, {u / radius, v / radius});
      },
      [=](double, double) { return colour; });
}

}  // namespace

void add_printed_shapes(Layout& layout, std::int64_t count, std::uint64_t seed) {
  RandomGenerator random(seed, "lab printed shapes");
  for (std::int64_t i = 0; i < count; ++i) {
    const double width_m = random.real(0.15, 0.6);
    const Spot spot{random.real(-0.9, 0.9), random.real(-0.2, 1.0), 0.04};
    layout.add_panel(Facing::back_wall, spot, width_m, width_m, 200.0, paint_shape);
  }
}

}  // namespace saccade::lab
