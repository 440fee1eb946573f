#include "config/warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "config/cameras.h"
#include "control/head_kinematics.h"
#include "core/units.h"
#include "sim/trajectory.h"

namespace saccade {
namespace {

std::string rounded(double value) { return text_of(std::round(value * 10.0) / 10.0); }

void check_camera(const std::string& block, const Camera& camera, std::vector<std::string>& warnings) {
  const double width = camera.size.width;
  const double height = camera.size.height;
  const bool inside = camera.cx_px >= -0.5 && camera.cx_px <= width - 0.5 && camera.cy_px >= -0.5 &&
                      camera.cy_px <= height - 0.5;
  if (!inside) {
    warnings.push_back(block + ": the principal point (" + text_of(camera.cx_px) + ", " +
                       text_of(camera.cy_px) + ") lies outside the image of " + in_words(camera.size));
  }
  constexpr Range plausible_view_deg{5.0, 150.0};
  const double view_deg = field_of_view_deg(camera);
  if (!plausible_view_deg.contains(view_deg)) {
    warnings.push_back(block + ": the camera sees " + rounded(view_deg) +
                       " deg from left to right; are focal length and image size those of one camera?");
  }
  constexpr double largest_aspect = 1.05;
  const double aspect = camera.fx_px / camera.fy_px;
  if (std::max(aspect, 1.0 / aspect) > largest_aspect) {
    warnings.push_back(block + ": fx_px: " + text_of(camera.fx_px) + " and fy_px: " + text_of(camera.fy_px) +
                       " differ by more than 5 %; pixels of event cameras are square");
  }
  constexpr double largest_share = 0.25;  // of the diagonal
  constexpr int steps = 8;
  const Camera ideal = camera.without_distortion();
  double largest_px = 0.0;
  for (int i = 0; i <= steps; ++i) {
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector2d seen(width * i / steps - 0.5, height * k / steps - 0.5);
      const auto straight = ideal.project(camera.ray(seen.x(), seen.y()));
      if (straight) largest_px = std::max(largest_px, (*straight - seen).norm());
    }
  }
  if (largest_px > largest_share * std::hypot(width, height)) {
    warnings.push_back(block + ": the lens moves a point of the image by " + rounded(largest_px) +
                       " px; is it the lens of an image of " + in_words(camera.size) + "?");
  }
}

/// The ball's smallest and largest radius in the left image, px.
std::array<double, 2> ball_radius_px(const Scenario& scenario) {
  const WorldConfig& world = scenario.sim.world;
  const auto head = head_model(world.head);
  const Eigen::Vector3d eye_m =
      HeadKinematics(head->chain, initial_pose_rad(world, *head)).root_from_eye(Eye::left).translation();
  const Trajectory trajectory(world.ball.trajectory, static_cast<std::uint64_t>(scenario.seed));
  const Camera& camera = scenario.sim.camera;
  const double focal_px = std::sqrt(camera.fx_px * camera.fy_px);
  const double radius_m = world.ball.diameter_m / 2.0;
  constexpr int samples = 2000;
  std::array<double, 2> range = {std::numeric_limits<double>::infinity(), 0.0};
  for (int i = 0; i <= samples; ++i) {
    const auto t_us = std::llround(scenario.run.duration_s * 1e6 * i / samples);
    const double distance_m = (trajectory.position_m(t_us) - eye_m).norm();
    if (distance_m <= radius_m) continue;
    const double r_px = focal_px * radius_m / std::sqrt(distance_m * distance_m - radius_m * radius_m);
    range = {std::min(range[0], r_px), std::max(range[1], r_px)};
  }
  return range;
}

void check_radii(const Scenario& scenario, std::vector<std::string>& warnings) {
  if (scenario.detectors.empty() || !scenario.sim.world.ball.present) return;
  const auto [smallest_px, largest_px] = ball_radius_px(scenario);
  const KeyValues keys = keys_of_detectors(scenario.detectors);
  for (const auto& [name, config] : scenario.detectors) {
    const std::string key = "detectors." + name + ".radius_px";
    const std::vector<double> radii_px = keys.numbers(key);
    if (radii_px.size() != 2 || (largest_px >= radii_px[0] && smallest_px <= radii_px[1])) continue;
    warnings.push_back(key + ": the ball's radius in the image is " + rounded(smallest_px) + " to " +
                       rounded(largest_px) + " px, never in [" + text_of(radii_px[0]) + ", " +
                       text_of(radii_px[1]) + "]");
  }
}

}  // namespace

std::vector<std::string> warnings_of(const Scenario& scenario) {
  std::vector<std::string> warnings;
  check_camera("camera", scenario.sim.camera, warnings);
  if (scenario.calibration.camera != scenario.sim.camera)
    check_camera("calibration", scenario.calibration.camera, warnings);
  if (scenario.sim.both_eyes()) {
    check_camera("right_camera", scenario.sim.right.camera, warnings);
    if (scenario.right_calibration.camera != scenario.sim.right.camera)
      check_camera("right_calibration", scenario.right_calibration.camera, warnings);
  }
  check_radii(scenario, warnings);
  return warnings;
}

}  // namespace saccade
