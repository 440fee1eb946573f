#pragma once

#include <Eigen/Geometry>
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

}  // namespace saccade
