#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "core/camera.h"
#include "core/config.h"

namespace saccade {

/// The status of a gaze target: accepted, or why not.
enum class TargetStatus {
  none,        ///< no target
  ok,          ///< accepted
  not_finite,  ///< NaN or infinite
  bad_radius,  ///< a circle without a positive radius
  too_near,    ///< closer than the head can look
  behind,      ///< behind the camera, or behind the chest
  too_far,     ///< farther than a ball can be seen
  in_body,     ///< inside the robot's own body
};

/// How the depth of a ball follows from the radius of its circle.
enum class DepthModel {
  pinhole,         ///< from the size of the ball
  authors_linear,  ///< the map of the authors' code (2016), see TargetLocator
};
constexpr auto words_of(DepthModel) {
  return std::to_array<Word<DepthModel>>(
      {{DepthModel::pinhole, "pinhole"}, {DepthModel::authors_linear, "authors_linear"}});
}

struct TargetConfig {
  DepthModel depth = DepthModel::pinhole;
  double ball_diameter_m = 0.095;  ///< pinhole only
  double min_distance_m = 0.10;    ///< from the camera; a nearer target is refused
  double max_distance_m = 10.0;    ///< from the camera; a farther target is refused
  double body_radius_m =
      0.08;  ///< of the body around the root's vertical axis; a target inside it is refused
};

/// Keys: depth, ball_diameter_m, min_distance_m, max_distance_m, body_radius_m.
void describe(FieldVisitor& v, TargetConfig& config);

struct Target {
  TargetStatus status = TargetStatus::none;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< ball centre, root frame; valid only if ok
};

/// The centre, m, camera frame, of the sphere with the outline `circle`: the inverse of Camera::project_sphere, exact off
/// the axis and through the lens. NaN if no sphere wholly in front of the camera and inside the field of the lens has that
/// outline.
[[nodiscard]] Eigen::Vector3d sphere_from_circle(const Circle& circle, const Camera& camera, double radius_m);

/// Converts a circle in the image to a point in the root frame.
///
/// `pinhole`: depth from the size of the ball. `authors_linear`: the map of the authors' code (2016), depth along the
/// optical axis z = (70 - 2.5 r) / 100 m for r px, made for their 128 x 128 camera: 16 px at 0.30 m.
class TargetLocator {
 public:
  explicit TargetLocator(const TargetConfig& config);  ///< throws InputError

  [[nodiscard]] Target locate(const Circle& circle, const Camera& camera,
                              const Eigen::Isometry3d& root_from_cam) const;

 private:
  DepthModel depth_;
  double ball_radius_m_;
  double min_distance_m_;
  double max_distance_m_;
  double body_radius_m_;
};

/// A ray from the pinhole of a camera, root frame.
struct Ray {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< not zero; its length does not matter
};

/// The intersection of two rays: the midpoint of their common perpendicular. None if they are parallel within
/// min_convergence_rad, if the point is behind a pinhole, or if `right` leaves the epipolar plane (of `left` and the
/// baseline) by more than max_skew_rad. A bearing error of 1 px (10 mrad) moves the point by z^2 / baseline times that:
/// 30 mm at 0.45 m for the eyes of the iCub.
[[nodiscard]] std::optional<Eigen::Vector3d> triangulate(const Ray& left, const Ray& right,
                                                         double min_convergence_rad, double max_skew_rad);

/// Corrects the distance of a target of the left eye by triangulation with the right eye.
class StereoLocator {
 public:
  static constexpr double min_convergence_rad = 0.017;  ///< 1 deg: 3.9 m before the iCub's eyes
  static constexpr double max_skew_rad = 0.026;         ///< 1.5 deg, 2.6 px

  explicit StereoLocator(const TargetConfig& config);  ///< throws InputError

  /// Moves `target_m`, the ball's centre according to the left eye at `left_eye_m`, along its bearing to the intersection
  /// with the bearing of the right eye: triangulate() with the bounds above. Points in the root frame. None if
  /// `right_circle` is not the outline of a ball, if the bearings do not intersect, or if the intersection is nearer than
  /// TargetConfig::min_distance_m or farther than max_distance_m.
  [[nodiscard]] std::optional<Eigen::Vector3d> locate(const Eigen::Vector3d& target_m,
                                                      const Eigen::Vector3d& left_eye_m,
                                                      const Circle& right_circle, const Camera& right_camera,
                                                      const Eigen::Isometry3d& root_from_right_cam) const;

 private:
  TargetLocator right_;
  double min_distance_m_;
  double max_distance_m_;
};

}  // namespace saccade
