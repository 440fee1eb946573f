#pragma once

#include <Eigen/Geometry>
#include <array>
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

/// How a lens bends rays.
enum class LensModel {
  radial_tangential,  ///< OpenCV's k1, k2, p1, p2, k3: a pinhole with distortion
  fisheye,  ///< OpenCV's fisheye model, k1 to k4 (Kannala, Brandt, PAMI 28(8), 2006): equidistant where all are 0
};
constexpr auto words_of(LensModel) {
  return std::to_array<Word<LensModel>>(
      {{LensModel::radial_tangential, "radial_tangential"}, {LensModel::fisheye, "fisheye"}});
}

/// A camera with a lens in OpenCV's convention: x right, y down, z forward; pixel (0, 0) is the centre of
/// the top-left pixel. A point (x, y) at unit depth is projected to the pixel (cx + fx x', cy + fy y'), with
/// s = x^2 + y^2 and, for a lens radial_tangential,
///
///     x' = x (1 + k1 s + k2 s^2 + k3 s^3) + 2 p1 x y + p2 (s + 2 x^2)
///     y' = y (1 + k1 s + k2 s^2 + k3 s^3) + 2 p2 x y + p1 (s + 2 y^2)
///
/// or for a fisheye, with a = atan(sqrt(s)) the angle from the optical axis, below 90 deg,
///
///     (x', y') = (x, y) a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8) / sqrt(s)
///
/// The lens ends where x' would turn back towards the axis: from 1 + 3 k1 s + 5 k2 s^2 + 7 k3 s^3 = 0 (fisheye:
/// 1 + 3 k1 a^2 + 5 k2 a^4 + 7 k3 a^6 + 9 k4 a^8 = 0) on it shows nothing.
/// Without numbers it has no image and is no valid camera.
struct Camera {
  ImageSize size;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  double k1 = 0.0;  ///< radial distortion
  double k2 = 0.0;  ///< radial distortion
  double p1 = 0.0;  ///< tangential distortion
  double p2 = 0.0;  ///< tangential distortion
  LensModel lens = LensModel::radial_tangential;
  double k3 = 0.0;  ///< radial distortion
  double k4 = 0.0;  ///< of a fisheye

  /// False for an exact pinhole.
  [[nodiscard]] bool has_lens() const {
    return lens == LensModel::fisheye || k1 != 0.0 || k2 != 0.0 || p1 != 0.0 || p2 != 0.0 || k3 != 0.0;
  }
  /// The same as an exact pinhole.
  [[nodiscard]] Camera without_lens() const;
  /// The same without distortion: an exact pinhole, or for a fisheye the equidistant lens.
  [[nodiscard]] Camera without_distortion() const;

  /// Pixel of a point in the camera frame, m; none when it is not in front of the camera or where the lens
  /// shows nothing.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_m) const;
  /// Point at unit depth along the ray through a pixel, the inverse of `project`: to 1e-12 over the image of a
  /// camera that keeps what `describe` demands, and some way around it. NaN where no ray is found.
  [[nodiscard]] Eigen::Vector3d ray(double u_px, double v_px) const;
  /// The circle that stands for the outline of a sphere: centroid and sqrt(area / pi) of the outline in the image.
  /// Without a lens those are the centre and sqrt(ab) of an ellipse; off the axis that is neither the
  /// projected centre nor f R / Z. `centre_m` in the camera frame; none when the sphere is not wholly in front
  /// of the camera, or reaches where the lens shows nothing.
  /// Formula: the outline is the cone (d.x)^2 = (|d|^2 - R^2)|x|^2 cut with the image plane.
  [[nodiscard]] std::optional<Circle> project_sphere(const Eigen::Vector3d& centre_m, double radius_m) const;
  /// The same for the ellipse centre + a cos t + b sin t on the plane at unit depth. Green's theorem: exact over 16
  /// points through a lens radial_tangential, whose integrands are trigonometric polynomials of degree 15 (with k3 21: 32 points);
  /// over 64 points through a fisheye, to about 1e-9 px for a ball 60 deg off the axis.
  [[nodiscard]] std::optional<Circle> project_ellipse(const Eigen::Vector2d& centre, const Eigen::Vector2d& a,
                                                      const Eigen::Vector2d& b) const;
  /// Image velocity, px/s, of a resting point on `ray` (a point at unit depth) while the camera turns at
  /// angular_velocity_rad_s (its own frame). It does not depend on the distance of the point.
  [[nodiscard]] Eigen::Vector2d rotational_flow_px_s(const Eigen::Vector3d& ray,
                                                     const Eigen::Vector3d& angular_velocity_rad_s) const;
  friend bool operator==(const Camera&, const Camera&) = default;
};

/// Keys: width_px, height_px.
void describe_image_size(FieldVisitor& v, Camera& camera);
/// Keys: lens, fx_px, fy_px, cx_px, cy_px, k1, k2, k3, p1, p2 (fisheye: k1, k2, k3, k4). While a file is read, another lens
/// than before starts without distortion.
void describe_lens(FieldVisitor& v, Camera& camera);
/// Whether every pixel up to the image's border has a ray, and around it the lens turns nothing inside out.
[[nodiscard]] bool is_invertible(const Camera& camera);
/// The condition on these keys: the lens is invertible.
void require_invertible(FieldVisitor& v, const Camera& camera);
/// Keys: width_px, height_px and those of describe_lens, with require_invertible.
void describe(FieldVisitor& v, Camera& camera);

/// Where a camera sits in its eye. The eye's frame is that of control/head_kinematics.h: at the eye's centre, axes as
/// a camera has them. Default: the pinhole is the eye's centre and the optical axis the eye's (iCub heads of 2022
/// have their event cameras at z = -10 mm).
struct CameraMount {
  std::array<double, 3> translation_mm = {0.0, 0.0, 0.0};  ///< of the pinhole, eye frame
  std::array<double, 3> rotation_deg = {0.0, 0.0, 0.0};    ///< rotation vector: axis times angle, eye frame

  [[nodiscard]] Eigen::Isometry3d eye_from_camera() const;
  friend bool operator==(const CameraMount&, const CameraMount&) = default;
};

/// Keys: translation_mm, rotation_deg.
void describe(FieldVisitor& v, CameraMount& mount);

/// A camera mounted in an eye: its intrinsics, distortion and pose in the eye frame. The simulator uses the true values,
/// detectors and controllers the assumed ones.
struct MountedCamera {
  Camera camera;
  CameraMount mount;

  friend bool operator==(const MountedCamera&, const MountedCamera&) = default;
};

/// Keys: those of Camera, and eye_from_camera with those of CameraMount.
void describe(FieldVisitor& v, MountedCamera& mounted);

}  // namespace saccade
