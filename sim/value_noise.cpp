#include "sim/value_noise.h"

#include <cmath>

namespace saccade {
namespace {

double smooth(double t) { return t * t * (3.0 - 2.0 * t); }

}  // namespace

ValueNoise::ValueNoise(RandomGenerator& random) {
  for (float& v : lattice_) v = static_cast<float>(random.real(-1.0, 1.0));
}

double ValueNoise::at(double x, double y) const {
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

double ValueNoise::sum(double x, double y, int octaves, double falloff) const {
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

}  // namespace saccade
