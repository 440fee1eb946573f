#include "apps/serve/gaze_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "control/neck_solver.h"
#include "control/target.h"
#include "core/units.h"

namespace saccade {
namespace {

/// The point on the ray through a pixel of a pinhole camera at a depth; eye frame.
Eigen::Vector3d through_pixel(const Camera& camera, double u_px, double v_px, double z_m) {
  return z_m *
         Eigen::Vector3d((u_px - camera.cx_px) / camera.fx_px, (v_px - camera.cy_px) / camera.fy_px, 1.0);
}

}  // namespace

std::optional<Eigen::Vector3d> GazeGeometry::point(const std::string& kind, RequestWords& words) const {
  const JointVector& q = position_rad_;
  const HeadKinematics head(chain_, q);
  if (kind == "3D") {
    const auto values = words.numbers(3);
    if (values) return Eigen::Vector3d(*values);
  } else if (kind == "mono") {
    const std::string eye = words.next();
    const bool by_vergence = words.take("ver", 2);
    const auto values = words.numbers(3);
    if (!values || (eye != "left" && eye != "right") || (*values)[2] <= 0.0) return {};
    const Eye which = eye == "left" ? Eye::left : Eye::right;
    Eigen::Vector3d seen =
        through_pixel(cameras_[static_cast<std::size_t>(which)], (*values)[0], (*values)[1], 1.0);
    if (by_vergence) {
      const double half_rad = std::max((*values)[2], least_vergence_deg) / deg_per_rad / 2;
      seen *= CyclopeanEye(chain_, q).half_baseline_m() / std::tan(half_rad) / seen.norm();
    } else {
      seen *= (*values)[2];
    }
    return head.root_from_eye(which) * seen;
  } else if (kind == "stereo") {
    const auto values = words.numbers(4);
    if (!values) return {};
    const auto ray = [&](Eye eye, double u_px, double v_px) {
      const Eigen::Isometry3d& pose = head.root_from_eye(eye);
      return Ray{pose.translation(),
                 pose.linear() * through_pixel(cameras_[static_cast<std::size_t>(eye)], u_px, v_px, 1.0)};
    };
    return triangulate(ray(Eye::left, (*values)[0], (*values)[1]),
                       ray(Eye::right, (*values)[2], (*values)[3]), least_vergence_deg / deg_per_rad,
                       std::numbers::pi / 2);
  } else if (kind == "ang") {
    const std::string mode = words.next();
    const auto values = words.numbers(3);
    if (!values || (mode != "abs" && mode != "rel")) return {};
    // From the direction of gaze now, or from that of the head with the neck at 0.
    const bool relative = mode == "rel";
    JointVector from = q;
    if (!relative) from.tail<gaze_slots>().setZero();
    const CyclopeanEye eye(chain_, from);
    const double azimuth = (*values)[0] / deg_per_rad;
    const double elevation = (*values)[1] / deg_per_rad;
    const double vergence = std::max((*values)[2] / deg_per_rad + (relative ? q[eyes_vergence] : 0.0),
                                     least_vergence_deg / deg_per_rad);
    const Eigen::Vector3d direction(std::sin(azimuth) * std::cos(elevation), -std::sin(elevation),
                                    std::cos(azimuth) * std::cos(elevation));
    return eye.root_from_eye() * Eigen::Vector3d(eye.half_baseline_m() / std::tan(vergence / 2) * direction);
  }
  return {};
}

std::optional<Eigen::Vector3d> GazeGeometry::on_plane(RequestWords& words) const {
  const std::string eye = words.next();
  const auto values = words.numbers(6);
  if (!values || (eye != "left" && eye != "right")) return {};
  const Eye which = eye == "left" ? Eye::left : Eye::right;
  const Eigen::Isometry3d pose = HeadKinematics(chain_, position_rad_).root_from_eye(which);
  const Eigen::Vector3d ray = pose.linear() * through_pixel(cameras_[static_cast<std::size_t>(which)],
                                                            (*values)[0], (*values)[1], 1.0);
  const Eigen::Vector3d normal = values->segment<3>(2);
  const double towards = normal.dot(ray);
  const double depth_m = -(normal.dot(pose.translation()) + (*values)[5]) / towards;
  if (!std::isfinite(depth_m) || depth_m <= 0.0) return {};
  return pose.translation() + depth_m * ray;
}

Eigen::Vector3d GazeGeometry::fixation_m() const {
  const FixationPoint fixation = HeadKinematics(chain_, position_rad_).fixation();
  if (fixation.valid) return fixation.point_m;
  const CyclopeanEye eye(chain_, position_rad_);
  const double distance_m = eye.half_baseline_m() / std::tan(least_vergence_deg / deg_per_rad / 2);
  return eye.root_from_eye() * Eigen::Vector3d(0.0, 0.0, distance_m);
}

Eigen::Vector3d GazeGeometry::angles_deg(const Eigen::Vector3d& point_m) const {
  JointVector upright = position_rad_;
  upright.tail<gaze_slots>().setZero();
  const CyclopeanEye eye(chain_, upright);
  const Eigen::Vector3d seen = eye.see(point_m);
  return Eigen::Vector3d(std::atan2(seen.x(), seen.z()), -std::atan2(seen.y(), std::abs(seen.z())),
                         2.0 * std::atan2(eye.half_baseline_m(), seen.norm())) *
         deg_per_rad;
}

std::string pinholes_text(const std::array<Camera, 2>& cameras) {
  std::string text;
  for (const Eye eye : {Eye::left, Eye::right}) {
    const std::string_view name = eye == Eye::left ? "left" : "right";
    const Camera& camera = cameras[static_cast<std::size_t>(eye)];
    text += fmt::format(
        "{}(camera_intrinsics_{} ({} 0.0 {} 0.0 0.0 {} {} 0.0 0.0 0.0 1.0 0.0)) (camera_width_{} {}) "
        "(camera_height_{} {})",
        text.empty() ? "" : " ", name, camera.fx_px, camera.cx_px, camera.fy_px, camera.cy_px, name,
        camera.size.width, name, camera.size.height);
  }
  return text;
}

bool read_pinholes(RequestWords& words, std::array<Camera, 2>& cameras) {
  std::array<Camera, 2> read = cameras;
  while (words.has_more()) {
    const std::string key = words.next();
    const auto eye = key.ends_with("_left")    ? std::optional(Eye::left)
                     : key.ends_with("_right") ? std::optional(Eye::right)
                                               : std::nullopt;
    if (!eye) return false;
    Camera& camera = read[static_cast<std::size_t>(*eye)];
    const std::string what = key.substr(0, key.rfind('_'));
    const auto values = words.next_numbers(what == "camera_intrinsics" ? 12 : 1);
    if (!values) return false;
    if (what == "camera_intrinsics") {
      if ((*values)[0] <= 0.0 || (*values)[5] <= 0.0) return false;
      camera.fx_px = (*values)[0];
      camera.cx_px = (*values)[2];
      camera.fy_px = (*values)[5];
      camera.cy_px = (*values)[6];
    } else if ((what != "camera_width" || (*values)[0] != camera.size.width) &&
               (what != "camera_height" || (*values)[0] != camera.size.height)) {
      return false;
    }
  }
  cameras = read;
  return true;
}

}  // namespace saccade
