#include "sim/pendulum.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.h"

namespace saccade {
namespace {

constexpr double pendulum_gravity_m_s2 = 9.81;

/// The elliptic function cd(u, k) by descending Landen transformations (Abramowitz and Stegun, 16.4), 0 < k < 1.
double elliptic_cd(double u, double k) {
  constexpr std::size_t steps = 8;
  std::array<double, steps + 1> a{};
  std::array<double, steps + 1> c{};
  a[0] = 1.0;
  c[0] = k;
  double b = std::sqrt(1.0 - k * k);
  for (std::size_t n = 0; n < steps; ++n) {
    a[n + 1] = 0.5 * (a[n] + b);
    c[n + 1] = 0.5 * (a[n] - b);
    b = std::sqrt(a[n] * b);
  }
  double phi = std::ldexp(a[steps] * u, static_cast<int>(steps));
  for (std::size_t n = steps; n > 0; --n) {
    phi = 0.5 * (phi + std::asin(std::clamp(c[n] / a[n] * std::sin(phi), -1.0, 1.0)));
  }
  const double sn = std::sin(phi);
  return std::cos(phi) / std::sqrt(1.0 - k * k * sn * sn);
}

}  // namespace

void describe(FieldVisitor& v, PendulumConfig& c) {
  v.reals("pivot_m", c.pivot_m, {-5.0, 5.0}, "point from which the object hangs, root frame");
  v.real("length_m", c.length_m, {0.05, 5.0}, "from the pivot to the centre of the object");
  v.real("amplitude_deg", c.amplitude_deg, {0.1, 170.0}, "largest angle from the vertical, where it starts");
  v.real("plane_deg", c.plane_deg, {-180.0, 180.0},
         "plane of the swing: 0 from side to side (y), 90 to the robot and back (x)");
}

Pendulum::Pendulum(const PendulumConfig& config)
    : pivot_m_(config.pivot_m),
      sideways_(std::sin(config.plane_deg * rad_per_deg), std::cos(config.plane_deg * rad_per_deg), 0.0),
      length_m_(config.length_m),
      angular_rad_s_(std::sqrt(pendulum_gravity_m_s2 / config.length_m)),
      modulus_(std::sin(0.5 * config.amplitude_deg * rad_per_deg)) {}

double Pendulum::angle_rad(double t_s) const {
  return 2.0 * std::asin(modulus_ * elliptic_cd(angular_rad_s_ * std::max(t_s, 0.0), modulus_));
}

Eigen::Vector3d Pendulum::position_m(double t_s) const {
  const double angle = angle_rad(t_s);
  return pivot_m_ + length_m_ * (std::sin(angle) * sideways_ - std::cos(angle) * Eigen::Vector3d::UnitZ());
}

Eigen::Quaterniond Pendulum::turn(double t_s) const {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad(t_s), sideways_.cross(Eigen::Vector3d::UnitZ())));
}

}  // namespace saccade
