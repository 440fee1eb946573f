#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/config.h"
#include "core/event.h"

namespace saccade {

/// A circle in the image: centre and radius, pixels.
struct Circle {
  double x_px = 0.0;
  double y_px = 0.0;
  double r_px = 0.0;
};

/// A pinhole camera without distortion in OpenCV's convention: x right, y down, z forward; pixel (0, 0)
/// is the centre of the top-left pixel. Defaults: left DVS128 of iCubGenova02 (icubEyes_DVS.ini, 2016).
struct PinholeCamera {
  ImageSize size{128, 128};
  double fx_px = 99.45;
  double fy_px = 99.75;
  double cx_px = 64.00;
  double cy_px = 69.18;

  /// Pixel of a point in the camera frame, m; none when it is not in front of the camera.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_m) const;
  /// Point at unit depth along the ray through a pixel: ((u - cx) / fx, (v - cy) / fy, 1).
  [[nodiscard]] Eigen::Vector3d ray(double u_px, double v_px) const;
  /// The circle that stands for a sphere's outline: centre and sqrt(ab) of the ellipse it projects to.
  /// Off the axis that is neither the projected centre nor f R / Z. `centre_m` in the camera frame; none
  /// when the sphere is not wholly in front of the camera.
  /// Formula: the outline is the cone (d.x)^2 = (|d|^2 - R^2)|x|^2 cut with the image plane.
  [[nodiscard]] std::optional<Circle> project_sphere(const Eigen::Vector3d& centre_m, double radius_m) const;
  /// How fast the image moves at a pixel, px/s, when the camera turns at angular_velocity_rad_s (its own frame)
  /// and the world stands still; distance does not matter.
  [[nodiscard]] Eigen::Vector2d rotational_flow_px_s(double u_px, double v_px,
                                                     const Eigen::Vector3d& angular_velocity_rad_s) const;
  friend bool operator==(const PinholeCamera&, const PinholeCamera&) = default;
};

/// Keys: width_px, height_px, fx_px, fy_px, cx_px, cy_px.
void describe(FieldVisitor& v, PinholeCamera& camera);

}  // namespace saccade
