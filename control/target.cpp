#include "control/target.h"

#include <algorithm>
#include <cmath>

namespace saccade {

void describe(FieldVisitor& v, TargetConfig& config) {
  v.choice("depth", config.depth, {"pinhole", "authors_linear"}, "how a circle's radius tells its depth");
  v.real("ball_diameter_m", config.ball_diameter_m, {0.005, 1.0}, "the ball's diameter, for depth: pinhole");
  v.real("min_distance_m", config.min_distance_m, {0.0, 10.0}, "a target nearer to the camera is refused");
}

Eigen::Vector3d sphere_from_circle(const Circle& circle, const PinholeCamera& camera, double radius_m) {
  // A sphere seen under the half-angle a at the angle t off the axis has, on the plane z = 1, an outline
  // with centre rho = sin t cos t / w and product of semi-axes ab = x sqrt(1 - x) / w^1.5, where
  // x = sin^2 a and w = cos^2 t - x. Eliminating t leaves w(x), then one equation in x.
  const Eigen::Vector3d ray = camera.ray(circle.x_px, circle.y_px);
  const double rho2 = ray.head<2>().squaredNorm();
  const double ab = circle.r_px * circle.r_px / (camera.fx_px * camera.fy_px);
  const auto root = [&](double x) { return std::sqrt(1.0 + 4.0 * rho2 * x * (1.0 - x)); };
  const auto w_of = [&](double x) { return (1.0 - 2.0 * x + root(x)) / (2.0 * (1.0 + rho2)); };

  // Newton on the logarithm of the equation over ln x, which is nearly straight; starts at the exact answer
  // for a sphere on the axis and stays inside (0, 1).
  double x = ab / (1.0 + ab);
  constexpr int max_iterations = 40;
  for (int i = 0; i < max_iterations; ++i) {
    const double w = w_of(x);
    const double dw = (rho2 * (1.0 - 2.0 * x) / root(x) - 1.0) / (1.0 + rho2);
    const double residual = std::log(x) + 0.5 * std::log1p(-x) - 1.5 * std::log(w) - std::log(ab);
    const double slope = 1.0 - 0.5 * x / (1.0 - x) - 1.5 * x * dw / w;
    const double next = std::min(x * std::exp(std::clamp(-residual / slope, -2.0, 2.0)), 0.5 * (1.0 + x));
    const bool done = std::abs(next - x) <= 1e-15 * x;
    x = next;
    if (done) break;
  }
  const double w = w_of(x);
  const double cosine = std::sqrt(w + x);
  const Eigen::Vector3d direction(ray.x() * w / cosine, ray.y() * w / cosine, cosine);
  return direction * (radius_m / std::sqrt(x));
}

TargetLocator::TargetLocator(const TargetConfig& config)
    : pinhole_(config.depth == "pinhole"),
      ball_radius_m_(config.ball_diameter_m / 2),
      min_distance_m_(config.min_distance_m) {
  check_config("target", config);
}

Target TargetLocator::locate(const Circle& circle, const PinholeCamera& camera,
                             const Eigen::Isometry3d& root_from_cam) const {
  const Eigen::Vector3d values(circle.x_px, circle.y_px, circle.r_px);
  if (!values.allFinite() || !root_from_cam.matrix().allFinite()) return {TargetStatus::not_finite, {}};
  if (!(circle.r_px > 0.0)) return {TargetStatus::bad_radius, {}};
  const Eigen::Vector3d point =
      pinhole_ ? sphere_from_circle(circle, camera, ball_radius_m_)
               : Eigen::Vector3d((70.0 - 2.5 * circle.r_px) / 100.0 * camera.ray(circle.x_px, circle.y_px));
  if (!point.allFinite()) return {TargetStatus::not_finite, {}};
  if (!(point.z() > 0.0)) return {TargetStatus::behind, {}};
  if (point.norm() < min_distance_m_) return {TargetStatus::too_near, {}};
  return {TargetStatus::ok, root_from_cam * point};
}

}  // namespace saccade
