#include "sim/keyframe_rule.h"

#include <algorithm>
#include <cmath>

namespace saccade::detail {
namespace {

constexpr double largest_shade_rad = 0.03;  ///< change of the direction of light: 3 % of it at the terminator
constexpr double largest_scale = 0.08;      ///< relative change of size in the image
constexpr double visible_shine = 0.03;      ///< of full brightness

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

bool KeyframeRule::permits(const Keyframe& key, const SceneLayer& layer, const Eigen::Vector3d& middle_m,
                           const Eigen::Isometry3d& camera_from_layer,
                           const Eigen::Matrix3d& root_from_layer) const {
  if (!key.is_drawn) return false;
  const Eigen::Isometry3d key_from_camera = key.camera_from_layer * camera_from_layer.inverse();
  if ((layer.is_room() || key.is_clipped) && !shows_border(key, key_from_camera)) return false;
  if (key.rect.is_empty()) return key.is_clipped;  // too small for a sample: it may grow

  const double focal_px = camera_->focal() / camera_->samples();
  const Eigen::Vector3d& moved_m = key_from_camera.translation();
  const double parallax_px =
      focal_px * (moved_m.head<2>().norm() + std::abs(moved_m.z())) * key.largest_step_1_m;
  if (parallax_px > error_px_) return false;
  if (std::abs(moved_m.z()) * key.nearest_1_m > largest_scale) return false;
  if (layer.is_room()) return true;

  // Where the camera is, seen from the layer.
  const Eigen::Vector3d eye_then = key.camera_from_layer.inverse().translation() - middle_m;
  const Eigen::Vector3d eye_now = camera_from_layer.inverse().translation() - middle_m;
  const double view_rad = angle_between(eye_then, eye_now);
  const double turn_rad = Eigen::AngleAxisd(key.root_from_layer.transpose() * root_from_layer).angle();
  if (std::max(view_rad, turn_rad) > largest_shade_rad) return false;
  const double thickness_px = focal_px * layer.thickness_m * key.mean_1_m;
  const double outline_px = thickness_px * (layer.is_round ? 0.5 * view_rad * view_rad : view_rad);
  const double highlight_px = layer.shine > visible_shine ? thickness_px * (view_rad + turn_rad) : 0.0;
  return std::max(outline_px, highlight_px) <= error_px_;
}

/// Whether the keyframe shows everything along the border of the image, at all depths of the layer.
bool KeyframeRule::shows_border(const Keyframe& key, const Eigen::Isometry3d& key_from_camera) const {
  const SampleRect& rect = key.drawn;
  for (const double inverse_depth_1_m : {key.nearest_1_m, key.farthest_1_m}) {
    for (const Eigen::Vector3d& ray : rays_) {
      const Eigen::Vector3d point =
          key_from_camera.linear() * ray + key_from_camera.translation() * inverse_depth_1_m;
      if (!(point.z() > 0.1)) return false;
      const double u = camera_->focal() * point.x() / point.z() + camera_->centre_x();
      const double v = camera_->focal() * point.y() / point.z() + camera_->centre_y();
      const double pixel = camera_->samples();
      const bool inside_x = (u > rect.left + pixel || rect.left > 0) &&
                            (u < rect.right - pixel || rect.right < camera_->columns());
      const bool inside_y = (v > rect.top + pixel || rect.top > 0) &&
                            (v < rect.bottom - pixel || rect.bottom < camera_->rows());
      if (!inside_x || !inside_y) return false;
    }
  }
  return true;
}

}  // namespace saccade::detail
