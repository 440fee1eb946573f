#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "core/camera.h"
#include "core/config.h"

namespace saccade {

/// What became of a gaze target.
enum class TargetStatus {
  none,        ///< there was none
  ok,          ///< taken
  not_finite,  ///< NaN or infinite
  bad_radius,  ///< a circle without a positive radius
  too_near,    ///< closer than the head can look
  behind,      ///< behind the camera, or behind the chest
};

struct TargetConfig {
  std::string depth = "pinhole";   ///< how a circle's radius tells its depth: pinhole or authors_linear
  double ball_diameter_m = 0.095;  ///< pinhole only
  double min_distance_m = 0.10;    ///< from the camera; a nearer target is refused
};

/// Keys: depth, ball_diameter_m, min_distance_m.
void describe(FieldVisitor& v, TargetConfig& config);

struct Target {
  TargetStatus status = TargetStatus::none;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< ball centre, root; means nothing unless ok
};

/// The centre in the camera frame, m, of the sphere whose outline a circle stands for: the inverse of
/// Camera::project_sphere, off the axis and through the lens too. NaN where no sphere wholly in front and in
/// the lens's field has that outline.
[[nodiscard]] Eigen::Vector3d sphere_from_circle(const Circle& circle, const Camera& camera, double radius_m);

/// From a circle in the image to a point in the robot's root frame.
///
/// `pinhole` knows the ball's size. `authors_linear` is the map of the authors' own code (2016), depth along
/// the optical axis z = (70 - 2.5 r) / 100 m for r px, made for their 128 x 128 camera: 16 px at 0.30 m.
class TargetLocator {
 public:
  explicit TargetLocator(const TargetConfig& config);  ///< throws InputError

  [[nodiscard]] Target locate(const Circle& circle, const Camera& camera,
                              const Eigen::Isometry3d& root_from_cam) const;

 private:
  bool pinhole_;
  double ball_radius_m_;
  double min_distance_m_;
};

/// What an eye sees the middle of: where its pinhole is and the direction it looks in, root frame.
struct Ray {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< not zero; its length does not matter
};

/// Where two rays meet: the midpoint of their common perpendicular. None where they do not: they are parallel within
/// min_convergence_rad, the point is behind one of the pinholes, or `right` leaves the plane of `left` and of the line
/// between the pinholes (the epipolar plane) by more than max_skew_rad. A bearing that is off by 1 px (10 mrad) moves
/// the point by z^2 / baseline times that: by 30 mm at 0.45 m between the iCub's eyes.
[[nodiscard]] std::optional<Eigen::Vector3d> triangulate(const Ray& left, const Ray& right,
                                                         double min_convergence_rad, double max_skew_rad);

/// What the right eye adds to a target of the left one: its distance, by triangulation.
class StereoLocator {
 public:
  static constexpr double min_convergence_rad = 0.017;  ///< 1 deg: 3.9 m before the iCub's eyes
  static constexpr double max_skew_rad = 0.026;         ///< 1.5 deg, 2.6 px

  explicit StereoLocator(const TargetConfig& config);  ///< throws InputError

  /// `target_m` (root), what the left eye at `left_eye_m` takes for the ball's centre, moved along its bearing to
  /// where the right eye's bearing of the ball meets it: triangulate() with the bounds above. None where the right
  /// eye's circle is no ball's, they do not meet, or where they meet is nearer than TargetConfig::min_distance_m.
  [[nodiscard]] std::optional<Eigen::Vector3d> locate(const Eigen::Vector3d& target_m,
                                                      const Eigen::Vector3d& left_eye_m,
                                                      const Circle& right_circle, const Camera& right_camera,
                                                      const Eigen::Isometry3d& root_from_right_cam) const;

 private:
  TargetLocator right_;
  double min_distance_m_;
};

}  // namespace saccade
