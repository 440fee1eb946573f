#include "sim/lab_round.h"

#include <cmath>
#include <numbers>

#include "sim/random_generator.h"

namespace saccade::lab {
namespace {

using Eigen::Vector3d;

using std::numbers::pi;

/// Paints rings around the middle of a square canvas, from the outside in; `share` of the radius.
void ring(Canvas& canvas, double share, Reflectance colour) {
  const double middle = 0.5 * canvas.width();
  const double radius = share * middle;
  canvas.shape(
      middle, middle, radius + 0.01, 0.0, [=](double u, double v) { return radius - std::hypot(u, v); },
      [=](double, double) { return colour; });
}

/// A bar from the middle of a square canvas; lengths are shares of the radius.
void bar(Canvas& canvas, double angle_rad, double from, double to, double width, Reflectance colour) {
  const double middle = 0.5 * canvas.width();
  const double at = 0.5 * (from + to) * middle;
  canvas.tilted(middle + at * std::cos(angle_rad), middle + at * std::sin(angle_rad), (to - from) * middle,
                width * middle, angle_rad, [=](double, double) { return colour; });
}

void paint_disc(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(any_colour(random, 0.1, 0.8));
  const int rings = random.index(3);
  for (int i = 0; i < rings; ++i) ring(canvas, 0.75 - 0.3 * i, any_colour(random, 0.1, 0.8));
}

void paint_clock(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(any_colour(random, 0.1, 0.3));
  ring(canvas, 0.88, grey(random.real(0.7, 0.85)));
  for (int hour = 0; hour < 12; ++hour) bar(canvas, pi * hour / 6.0, 0.66, 0.8, 0.06, grey(0.12));
  bar(canvas, random.real(0.0, 2.0 * pi), -0.08, 0.45, 0.08, grey(0.12));
  bar(canvas, random.real(0.0, 2.0 * pi), -0.12, 0.7, 0.05, grey(0.12));
}

void paint_wheel(Canvas& canvas, RandomGenerator& random) {
  const Reflectance rim = grey(random.real(0.5, 0.8));
  canvas.fill(grey(0.1));
  ring(canvas, 0.78, rim);
  ring(canvas, 0.68, any_colour(random, 0.25, 0.5));
  const int spokes = 5 + random.index(8);
  for (int i = 0; i < spokes; ++i) bar(canvas, 2.0 * pi * i / spokes, 0.0, 0.7, 0.07, rim);
  ring(canvas, 0.16, grey(0.2));
}

void paint_coat(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(any_colour(random, 0.1, 0.8));
  if (random.chance(0.5)) {
    canvas.rectangle(0.0, random.real(0.2, 0.6) * canvas.height(), canvas.width(),
                     random.real(0.1, 0.3) * canvas.height(), any_colour(random, 0.1, 0.8));
  }
}

class RoundThingsOf {
 public:
  RoundThingsOf(Layout& layout, std::uint64_t seed) : layout_(layout), random_(seed, "lab round things") {}

  void on_wall(std::int64_t count, double smallest_m, double largest_m, const Painter& paint) {
    for (std::int64_t i = 0; i < count; ++i) {
      const double radius_m = random_.real(smallest_m, largest_m);
      const Spot spot{random_.real(-0.9, 0.9), random_.real(-0.2, 1.0), 0.05 + 0.008 * hung_++};
      layout_.add_disc(Facing::back_wall, spot, radius_m,
                       layout_.add_patch(2.0 * radius_m, 2.0 * radius_m, 200.0, paint));
    }
  }

  /// Returns where a thing of this radius stands: the middle of its foot, on a board.
  Vector3d on_board(double radius_m) {
    const double share = random_.real(0.0, 1.0);
    const double x = -0.75 + share * (layout_.back_m() + 0.35 + 0.75);
    const Vector3d foot(x, 0.4 * x * random_.real(-1.0, 1.0), 0.34 + 0.4 * x * random_.real(-0.6, 0.9));
    const double side_m = 2.0 * radius_m + 0.06;
    layout_.add_solid(foot - Vector3d(0.0, 0.0, 0.01), {0.5 * side_m, 0.5 * side_m, 0.01},
                      layout_.add_patch(side_m, side_m, 128.0, paint_wood), Facing::up);
    return foot;
  }

  void cups(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      const double radius_m = random_.real(0.03, 0.06);
      const double height_m = radius_m * random_.real(1.6, 2.8);
      const Vector3d foot = on_board(radius_m);
      layout_.add_column(foot, radius_m, height_m, layout_.add_patch(0.3, height_m, 200.0, paint_coat));
    }
  }

  void balls(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      const double radius_m = random_.real(0.025, 0.09);
      const Vector3d foot = on_board(radius_m);
      layout_.add_ball(foot + Vector3d(0.0, 0.0, radius_m), radius_m,
                       layout_.add_patch(6.0 * radius_m, 3.0 * radius_m, 200.0, paint_coat));
    }
  }

 private:
  Layout& layout_;
  RandomGenerator random_;
  int hung_ = 0;
};

}  // namespace

void add_round_things(Layout& layout, const RoundThings& round, std::uint64_t seed) {
  RoundThingsOf things(layout, seed);
  things.on_wall(round.discs, 0.06, 0.25, paint_disc);
  things.on_wall(round.clocks, 0.1, 0.2, paint_clock);
  things.on_wall(round.wheels, 0.15, 0.33, paint_wheel);
  things.cups(round.cups);
  things.balls(round.balls);
}

}  // namespace saccade::lab
