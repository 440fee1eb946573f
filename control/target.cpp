#include "control/target.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace saccade {

void describe(FieldVisitor& v, TargetConfig& config) {
  v.choice("depth", config.depth, "model of the depth that a radius stands for");
  v.real("ball_diameter_m", config.ball_diameter_m, {0.005, 1.0},
         "diameter of the ball, with depth: pinhole");
  v.real("min_distance_m", config.min_distance_m, {0.0, 10.0}, "targets nearer to the camera are rejected");
  v.real("max_distance_m", config.max_distance_m, {0.1, 100.0},
         "targets farther from the camera are rejected");
  v.real(
      "body_radius_m", config.body_radius_m, {0.0, 1.0},
      "targets below the eyes and this close to the vertical axis of the root frame are rejected: there is "
      "the robot's body");
  v.require(config.max_distance_m > config.min_distance_m, "max_distance_m", text_of(config.max_distance_m),
            "more than min_distance_m");
}

namespace {

/// The sphere whose outline on the plane at unit depth has the given centre and product of semi-axes ab.
Eigen::Vector3d sphere_from_ellipse(const Eigen::Vector3d& ray, double ab, double radius_m) {
  // A sphere seen under the half-angle a at the angle t off the axis has, on the plane z = 1, an outline
  // with centre rho = sin t cos t / w and product of semi-axes ab = x sqrt(1 - x) / w^1.5, where
  // x = sin^2 a and w = cos^2 t - x. Eliminating t leaves w(x), then one equation in x.
  const double rho2 = ray.head<2>().squaredNorm();
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

}  // namespace

Eigen::Vector3d sphere_from_circle(const Circle& circle, const Camera& camera, double radius_m) {
  // Exact without a lens; Newton from there with one. A place is (X / Z, Y / Z, ln Z).
  const auto point_of = [](const Eigen::Vector3d& place) {
    return Eigen::Vector3d(Eigen::Vector3d(place.x(), place.y(), 1.0) * std::exp(place.z()));
  };
  const auto seen_at = [&](const Eigen::Vector3d& place) -> std::optional<Eigen::Vector3d> {
    const auto seen = camera.project_sphere(point_of(place), radius_m);
    if (!seen) return std::nullopt;
    return Eigen::Vector3d(seen->x_px, seen->y_px, seen->r_px);
  };
  constexpr int max_iterations = 20;
  constexpr double close_px = 1e-9, aside = 1e-6, longest_step = 0.3;
  const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const Eigen::Vector3d wanted(circle.x_px, circle.y_px, circle.r_px);
  const Eigen::Vector3d start =
      sphere_from_ellipse(camera.ray(circle.x_px, circle.y_px),
                          circle.r_px * circle.r_px / (camera.fx_px * camera.fy_px), radius_m);
  Eigen::Vector3d place(start.x() / start.z(), start.y() / start.z(), std::log(start.z()));
  for (int i = 0; i < max_iterations; ++i) {
    const auto seen = seen_at(place);
    if (!seen) return nowhere;
    const Eigen::Vector3d off = wanted - *seen;
    if (off.norm() < close_px) return point_of(place);
    Eigen::Matrix3d slope;
    for (int k = 0; k < 3; ++k) {
      const auto beside = seen_at(place + aside * Eigen::Vector3d::Unit(k));
      if (!beside) return nowhere;
      slope.col(k) = (*beside - *seen) / aside;
    }
    const Eigen::Vector3d step = slope.inverse() * off;
    place += step * std::min(1.0, longest_step / step.norm());
  }
  return nowhere;
}

TargetLocator::TargetLocator(const TargetConfig& config)
    : depth_(config.depth),
      ball_radius_m_(config.ball_diameter_m / 2),
      min_distance_m_(config.min_distance_m),
      max_distance_m_(config.max_distance_m),
      body_radius_m_(config.body_radius_m) {
  check_config("target", config);
}

Target TargetLocator::locate(const Circle& circle, const Camera& camera,
                             const Eigen::Isometry3d& root_from_cam) const {
  const Eigen::Vector3d values(circle.x_px, circle.y_px, circle.r_px);
  if (!values.allFinite() || !root_from_cam.matrix().allFinite()) return {TargetStatus::not_finite, {}};
  if (!(circle.r_px > 0.0)) return {TargetStatus::bad_radius, {}};
  const Eigen::Vector3d point =
      depth_ == DepthModel::pinhole
          ? sphere_from_circle(circle, camera, ball_radius_m_)
          : Eigen::Vector3d((70.0 - 2.5 * circle.r_px) / 100.0 * camera.ray(circle.x_px, circle.y_px));
  if (!point.allFinite()) return {TargetStatus::not_finite, {}};
  if (!(point.z() > 0.0)) return {TargetStatus::behind, {}};
  if (point.norm() < min_distance_m_) return {TargetStatus::too_near, {}};
  if (point.norm() > max_distance_m_) return {TargetStatus::too_far, {}};
  const Eigen::Vector3d point_m = root_from_cam * point;
  const bool below_eyes = point_m.z() < root_from_cam.translation().z();
  if (below_eyes && point_m.head<2>().norm() < body_radius_m_) return {TargetStatus::in_body, {}};
  return {TargetStatus::ok, point_m};
}

std::optional<Eigen::Vector3d> triangulate(const Ray& left, const Ray& right, double min_convergence_rad,
                                           double max_skew_rad) {
  const Eigen::Vector3d a = left.direction.normalized();
  const Eigen::Vector3d b = right.direction.normalized();
  const Eigen::Vector3d baseline_m = right.origin_m - left.origin_m;
  const Eigen::Vector3d across = a.cross(b);
  if (!(across.norm() > std::sin(min_convergence_rad))) return std::nullopt;
  const Eigen::Vector3d plane = baseline_m.cross(a).normalized();
  if (!(std::abs(plane.dot(b)) <= std::sin(max_skew_rad))) return std::nullopt;
  const double along_a_m = baseline_m.cross(b).dot(across) / across.squaredNorm();
  const double along_b_m = baseline_m.cross(a).dot(across) / across.squaredNorm();
  if (!(along_a_m > 0.0) || !(along_b_m > 0.0)) return std::nullopt;
  return 0.5 * (left.origin_m + along_a_m * a + right.origin_m + along_b_m * b);
}

StereoLocator::StereoLocator(const TargetConfig& config)
    : right_(config), min_distance_m_(config.min_distance_m), max_distance_m_(config.max_distance_m) {}

std::optional<Eigen::Vector3d> StereoLocator::locate(const Eigen::Vector3d& target_m,
                                                     const Eigen::Vector3d& left_eye_m,
                                                     const Circle& right_circle, const Camera& right_camera,
                                                     const Eigen::Isometry3d& root_from_right_cam) const {
  const Target right = right_.locate(right_circle, right_camera, root_from_right_cam);
  if (right.status != TargetStatus::ok) return std::nullopt;
  const Eigen::Vector3d right_eye_m = root_from_right_cam.translation();
  const auto met_m =
      triangulate({left_eye_m, target_m - left_eye_m}, {right_eye_m, right.point_m - right_eye_m},
                  min_convergence_rad, max_skew_rad);
  if (!met_m) return std::nullopt;
  const double distance_m = (*met_m - left_eye_m).norm();
  if (distance_m < min_distance_m_ || distance_m > max_distance_m_) return std::nullopt;
  return met_m;
}

}  // namespace saccade
