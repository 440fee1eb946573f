#include "core/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/units.h"

namespace saccade {
namespace {

/// A fisheye's distance from the principal point, in focal lengths, at the angle a from the optical axis.
double fisheye_radius(const Camera& c, double a) {
  const double s = a * a;
  return a * (1.0 + s * (c.k1 + s * (c.k2 + s * (c.k3 + s * c.k4))));
}

/// Its derivative by the angle.
double fisheye_slope(const Camera& c, double a) {
  const double s = a * a;
  return 1.0 + s * (3.0 * c.k1 + s * (5.0 * c.k2 + s * (7.0 * c.k3 + s * 9.0 * c.k4)));
}

/// The smallest angle below 90 deg at which `slope` is no longer positive; else 90 deg.
template <class Slope>
double end_of(const Slope& slope) {
  constexpr double right_angle = std::numbers::pi / 2.0;
  constexpr int steps = 64;
  for (int i = 1; i <= steps; ++i) {
    double high = right_angle * i / steps;
    if (slope(high) > 0.0) continue;
    double low = right_angle * (i - 1) / steps;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (slope(middle) > 0.0 ? low : high) = middle;
    }
    return low;
  }
  return right_angle;
}

double fisheye_end_rad(const Camera& c) {
  constexpr double right_angle = std::numbers::pi / 2.0;
  constexpr double s = right_angle * right_angle;
  // The slope is above this at every angle: what lowers it is largest at a right angle.
  const double least =
      1.0 +
      s * (std::min(0.0, 3.0 * c.k1) +
           s * (std::min(0.0, 5.0 * c.k2) + s * (std::min(0.0, 7.0 * c.k3) + s * std::min(0.0, 9.0 * c.k4))));
  if (least > 1e-6) return right_angle;
  return end_of([&](double a) { return fisheye_slope(c, a); });
}

/// What a fisheye does to a point at unit depth, r from the optical axis: (x', y') = factor (x, y), and the derivative
/// factor I + outward (x, y) (x, y)^T.
struct FisheyeBend {
  double factor, outward;
};

FisheyeBend fisheye_bend(const Camera& c, double r) {
  constexpr double near_axis = 1e-4;  // there the first terms of the series are exact to 1e-15
  if (r < near_axis) return {1.0 + (c.k1 - 1.0 / 3.0) * r * r, 2.0 * (c.k1 - 1.0 / 3.0)};
  const double a = std::atan(r);
  const double factor = fisheye_radius(c, a) / r;
  return {factor, (fisheye_slope(c, a) / (1.0 + r * r) - factor) / (r * r)};
}

/// x' and y' of a point at unit depth.
Eigen::Vector2d distort(const Camera& c, const Eigen::Vector2d& q) {
  if (c.lens == LensModel::fisheye) return q * fisheye_bend(c, q.norm()).factor;
  const double s = q.squaredNorm();
  const double radial = 1.0 + s * (c.k1 + s * (c.k2 + s * c.k3));
  const double twice_xy = 2.0 * q.x() * q.y();
  return {q.x() * radial + c.p1 * twice_xy + c.p2 * (s + 2.0 * q.x() * q.x()),
          q.y() * radial + c.p2 * twice_xy + c.p1 * (s + 2.0 * q.y() * q.y())};
}

/// Its derivative by the point.
Eigen::Matrix2d jacobian(const Camera& c, const Eigen::Vector2d& q) {
  if (c.lens == LensModel::fisheye) {
    const FisheyeBend bend = fisheye_bend(c, q.norm());
    return bend.factor * Eigen::Matrix2d::Identity() + bend.outward * q * q.transpose();
  }
  const double s = q.squaredNorm();
  const double radial = 1.0 + s * (c.k1 + s * (c.k2 + s * c.k3));
  const double slope = 2.0 * (c.k1 + s * (2.0 * c.k2 + s * (3.0 * c.k3)));
  const double mixed = slope * q.x() * q.y() + 2.0 * (c.p1 * q.x() + c.p2 * q.y());
  Eigen::Matrix2d j;
  j << radial + slope * q.x() * q.x() + 2.0 * c.p1 * q.y() + 6.0 * c.p2 * q.x(), mixed,  //
      mixed, radial + slope * q.y() * q.y() + 2.0 * c.p2 * q.x() + 6.0 * c.p1 * q.y();
  return j;
}

/// The squared distance from the optical axis, at unit depth, where the lens ends.
double lens_end(const Camera& c) {
  if (c.lens == LensModel::fisheye || c.k3 != 0.0) {
    const double end_rad = c.lens == LensModel::fisheye ? fisheye_end_rad(c) : end_of([&](double a) {
      const double s = std::tan(a) * std::tan(a);
      return 1.0 + s * (3.0 * c.k1 + s * (5.0 * c.k2 + s * (7.0 * c.k3)));
    });
    const double r = std::tan(end_rad);
    return end_rad < std::numbers::pi / 2.0 ? r * r : std::numeric_limits<double>::infinity();
  }
  const double root = 3.0 * c.k1;
  const double discriminant = root * root - 20.0 * c.k2;
  const double divisor = discriminant < 0.0 ? 0.0 : std::sqrt(discriminant) - root;
  return divisor > 0.0 ? 2.0 / divisor : std::numeric_limits<double>::infinity();
}

/// The point at unit depth that a fisheye shows at `seen`; NaN where there is none.
Eigen::Vector2d fisheye_ray(const Camera& c, const Eigen::Vector2d& seen) {
  const double radius = seen.norm();
  if (radius == 0.0) return Eigen::Vector2d::Zero();
  const double end_rad = fisheye_end_rad(c);
  constexpr int max_steps = 30;
  constexpr double close = 1e-15;
  double low = 0.0;
  double high = end_rad;
  double a = std::min(radius, 0.5 * (low + high));
  if (!(fisheye_radius(c, high) > radius))
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < max_steps; ++i) {  // Newton's method inside a bracket
    const double missed = radius - fisheye_radius(c, a);
    (missed > 0.0 ? low : high) = a;
    const double step = missed / fisheye_slope(c, a);
    if (std::abs(step) < close) break;
    a = a + step > low && a + step < high ? a + step : 0.5 * (low + high);
  }
  return seen * (std::tan(a) / radius);
}

}  // namespace

Camera Camera::without_lens() const {
  Camera camera = without_distortion();
  camera.lens = LensModel::radial_tangential;
  return camera;
}

Camera Camera::without_distortion() const {
  Camera camera = *this;
  camera.k1 = camera.k2 = camera.p1 = camera.p2 = camera.k3 = camera.k4 = 0.0;
  return camera;
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& p) const {
  if (!(p.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d q = p.head<2>() / p.z();
  if (q.squaredNorm() >= lens_end(*this)) return std::nullopt;
  const Eigen::Vector2d seen = distort(*this, q);
  return Eigen::Vector2d(cx_px + fx_px * seen.x(), cy_px + fy_px * seen.y());
}

Eigen::Vector3d Camera::ray(double u_px, double v_px) const {
  constexpr int max_steps = 12;  // 5 or 6 are needed in the image's corners
  constexpr double close = 1e-13;
  const Eigen::Vector2d seen((u_px - cx_px) / fx_px, (v_px - cy_px) / fy_px);
  if (!has_lens()) return seen.homogeneous();
  if (lens == LensModel::fisheye) {
    const Eigen::Vector2d q = fisheye_ray(*this, seen);
    return {q.x(), q.y(), q.allFinite() ? 1.0 : std::numeric_limits<double>::quiet_NaN()};
  }
  Eigen::Vector2d q = seen;
  for (int i = 0; i < max_steps; ++i) {
    const Eigen::Vector2d missed = seen - distort(*this, q);
    if (missed.squaredNorm() < close * close) {
      if (q.squaredNorm() < lens_end(*this)) return q.homogeneous();
      break;
    }
    q += jacobian(*this, q).inverse() * missed;
  }
  return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

std::optional<Circle> Camera::project_sphere(const Eigen::Vector3d& d, double radius_m) const {
  const double k = d.squaredNorm() - radius_m * radius_m;
  if (!(k > 0.0) || !(d.z() > radius_m)) return std::nullopt;
  // On the plane z = 1 the cone cuts an ellipse; its longer axis points away from the optical axis.
  const double e = d.z() * d.z() - radius_m * radius_m;
  const double off_axis = d.head<2>().norm();
  const Eigen::Vector2d outward =
      off_axis > 0.0 ? Eigen::Vector2d(d.head<2>() / off_axis) : Eigen::Vector2d::UnitX();
  return project_ellipse(d.head<2>() * (d.z() / e), outward * (radius_m * std::sqrt(k) / e),
                         outward.unitOrthogonal() * (radius_m / std::sqrt(e)));
}

std::optional<Circle> Camera::project_ellipse(const Eigen::Vector2d& centre, const Eigen::Vector2d& a,
                                              const Eigen::Vector2d& b) const {
  const auto circle = [&](const Eigen::Vector2d& at, double area_over_pi) {
    return Circle{cx_px + fx_px * at.x(), cy_px + fy_px * at.y(),
                  std::sqrt(std::abs(area_over_pi) * fx_px * fy_px)};
  };
  if (!has_lens()) return circle(centre, a.x() * b.y() - a.y() * b.x());

  static const std::array<Eigen::Vector2d, 64> turn = [] {
    std::array<Eigen::Vector2d, 64> points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double t = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(points.size());
      points[i] = {std::cos(t), std::sin(t)};
    }
    return points;
  }();
  const double end = lens_end(*this);
  const Eigen::Vector2d middle = distort(*this, centre);
  double area = 0.0;                                 // the sum of x dy
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();  // of x^2 dy / 2 and -y^2 dx / 2
  const std::size_t every = lens == LensModel::fisheye ? 1 : k3 != 0.0 ? 2 : 4;
  for (std::size_t i = 0; i < turn.size(); i += every) {
    const Eigen::Vector2d& t = turn[i];
    const Eigen::Vector2d q = centre + a * t.x() + b * t.y();
    if (!(q.squaredNorm() < end)) return std::nullopt;
    const Eigen::Vector2d at = distort(*this, q) - middle;
    const Eigen::Vector2d step = jacobian(*this, q) * (b * t.x() - a * t.y());
    area += at.x() * step.y();
    moment += Eigen::Vector2d(at.x() * at.x() * step.y(), -at.y() * at.y() * step.x()) / 2.0;
  }
  const std::size_t points = turn.size() / every;
  return circle(middle + moment / area, 2.0 * area / static_cast<double>(points));
}

Eigen::Vector2d Camera::rotational_flow_px_s(const Eigen::Vector3d& ray, const Eigen::Vector3d& w) const {
  const double x = ray.x();
  const double y = ray.y();
  const Eigen::Vector2d flow(-w.y() * (1.0 + x * x) + w.x() * x * y + w.z() * y,
                             w.x() * (1.0 + y * y) - w.y() * x * y - w.z() * x);
  const Eigen::Vector2d seen = jacobian(*this, {x, y}) * flow;
  return {fx_px * seen.x(), fy_px * seen.y()};
}

Eigen::Isometry3d CameraMount::eye_from_camera() const {
  const Eigen::Vector3d turn_rad = Eigen::Map<const Eigen::Vector3d>(rotation_deg.data()) * rad_per_deg;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const double angle_rad = turn_rad.norm();
  if (angle_rad > 0.0) pose.linear() = Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad).toRotationMatrix();
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(translation_mm.data()) * 1e-3;
  return pose;
}

void describe_image_size(FieldVisitor& v, Camera& camera) {
  std::int64_t width = camera.size.width;
  std::int64_t height = camera.size.height;
  v.integer("width_px", width, {8, 2048}, "image width");
  v.integer("height_px", height, {8, 2048}, "image height");
  camera.size = {static_cast<int>(width), static_cast<int>(height)};
}

void describe_lens(FieldVisitor& v, Camera& camera) {
  const LensModel before = camera.lens;
  v.choice("lens", camera.lens,
           "model of the lens, as OpenCV has it; fisheye: equidistant where k1 to k4 are 0");
  if (v.fills_defaults() && camera.lens != before) {
    const LensModel now = camera.lens;
    camera = camera.without_distortion();
    camera.lens = now;
  }
  v.real("fx_px", camera.fx_px, {1.0, 1e5}, "focal length along x");
  v.real("fy_px", camera.fy_px, {1.0, 1e5}, "focal length along y");
  v.real("cx_px", camera.cx_px, {-1e4, 1e4}, "principal point, x");
  v.real("cy_px", camera.cy_px, {-1e4, 1e4}, "principal point, y");
  v.real("k1", camera.k1, {-10.0, 10.0}, "radial distortion, of r^2 (as OpenCV has it)");
  v.real("k2", camera.k2, {-10.0, 10.0}, "radial distortion, of r^4");
  v.real("k3", camera.k3, {-10.0, 10.0}, "radial distortion, of r^6");
  v.when(camera.lens == LensModel::radial_tangential, "lens: radial_tangential", [&] {
    v.real("p1", camera.p1, {-1.0, 1.0}, "tangential distortion, vertical");
    v.real("p2", camera.p2, {-1.0, 1.0}, "tangential distortion, horizontal");
  });
  v.when(camera.lens == LensModel::fisheye, "lens: fisheye", [&] {
    v.real("k4", camera.k4, {-10.0, 10.0}, "radial distortion, of r^8");
  });
}

bool is_invertible(const Camera& c) {
  constexpr int steps = 16;
  for (int i = 0; i <= steps; ++i) {
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector3d ray = c.ray(c.size.width * i / static_cast<double>(steps) - 0.5,
                                        c.size.height * k / static_cast<double>(steps) - 0.5);
      if (!(jacobian(c, ray.head<2>()).determinant() > 0.0)) return false;
    }
  }
  return true;
}

void require_invertible(FieldVisitor& v, const Camera& camera) {
  const bool focal = camera.fx_px > 0.0 && camera.fy_px > 0.0;
  const bool fisheye = camera.lens == LensModel::fisheye;
  v.require(
      !focal || is_invertible(camera), fisheye ? "fx_px" : "k1", text_of(fisheye ? camera.fx_px : camera.k1),
      fisheye
          ? "with k1 to k4 a lens that shows the whole image within 90 deg of its axis"
          : "with k2, k3, p1 and p2 a lens that can be inverted over the whole image (all of 0: no lens)");
}

void describe(FieldVisitor& v, Camera& camera) {
  describe_image_size(v, camera);
  describe_lens(v, camera);
  require_invertible(v, camera);
}

void describe(FieldVisitor& v, CameraMount& mount) {
  v.reals("translation_mm", mount.translation_mm, {-200.0, 200.0}, "position of the camera, eye frame");
  v.reals("rotation_deg", mount.rotation_deg, {-180.0, 180.0}, "rotation vector of the camera, eye frame");
}

void describe(FieldVisitor& v, MountedCamera& mounted) {
  describe(v, mounted.camera);
  v.section("eye_from_camera", mounted.mount, "pose of the camera in the eye");
}

}  // namespace saccade
