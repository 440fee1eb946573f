#include "worlds/outline_contrast.h"

#include <cmath>
#include <numbers>

#include "core/rotation_vector.h"

namespace saccade {
namespace {

constexpr int instants = 8;
constexpr int directions = 16;
constexpr double beside = 1.12;  ///< of the radius: where the lab is compared with the ball

}  // namespace

OutlineContrast::OutlineContrast(const LabConfig& lab, std::uint64_t seed, const CameraPath& path,
                                 const Camera& camera, const Trajectory& ball, double radius_m)
    : lab_(lab) {
  LabProbe probe(lab, seed);
  const std::size_t count = path.root_from_eye().size();
  for (int i = 0; i < instants; ++i) {
    const std::size_t at = count * static_cast<std::size_t>(i) / instants;
    const Eigen::Isometry3d& root_from_eye = path.root_from_eye()[at];
    const Eigen::Vector3d centre_m = ball.position_m(static_cast<std::int64_t>(at) * CameraPath::step_us);
    const auto circle = camera.project_sphere(root_from_eye.inverse() * centre_m, radius_m);
    if (!circle) continue;
    const Eigen::Vector3d eye_m = root_from_eye.translation();
    const Eigen::Vector3d towards = (centre_m - eye_m).normalized();
    for (int k = 0; k < directions; ++k) {
      const double angle_rad = 2.0 * std::numbers::pi * k / directions;
      const double x_px = circle->x_px + beside * circle->r_px * std::cos(angle_rad);
      const double y_px = circle->y_px + beside * circle->r_px * std::sin(angle_rad);
      if (x_px < 0.0 || y_px < 0.0 || x_px > camera.size.width - 1.0 || y_px > camera.size.height - 1.0) {
        continue;
      }
      const Eigen::Vector3d ray = root_from_eye.linear() * camera.ray(x_px, y_px);
      const Eigen::Vector3d normal = (ray - ray.dot(towards) * towards).normalized();
      points_.push_back({normal, towards, probe.luminance(eye_m, ray)});
    }
  }
}

double OutlineContrast::share(const BallConfig& ball, const EmulatorConfig& sensor) const {
  if (points_.empty()) return 0.0;
  const double needed = sensor.contrast_threshold_on + sensor.contrast_threshold_off;  // twice their mean
  const auto pattern_from_root = rotation_of(radians(ball.pattern_turn_deg)).inverse();
  const auto level = [&](double luminance) {
    return std::log(luminance + sensor.dark_current / sensor.white);
  };
  std::size_t good = 0;
  for (const Point& point : points_) {
    const double cover = pattern_cover(ball.pattern, pattern_from_root * point.normal);
    std::array<double, 3> rgb{};
    for (std::size_t i = 0; i < 3; ++i) rgb[i] = (1.0 - cover) * ball.rgb[i] + cover * ball.pattern_rgb[i];
    const double difference =
        level(lab_luminance(lab_, point.normal, point.towards, rgb)) - level(point.behind);
    if (std::abs(difference) >= needed) ++good;
  }
  return static_cast<double>(good) / static_cast<double>(points_.size());
}

}  // namespace saccade
