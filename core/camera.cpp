#include "core/camera.h"

#include <Eigen/Dense>
#include <cmath>

namespace saccade {

std::optional<Eigen::Vector2d> PinholeCamera::project(const Eigen::Vector3d& p) const {
  if (!(p.z() > 0.0)) return std::nullopt;
  return Eigen::Vector2d(cx_px + fx_px * p.x() / p.z(), cy_px + fy_px * p.y() / p.z());
}

Eigen::Vector3d PinholeCamera::ray(double u_px, double v_px) const {
  return {(u_px - cx_px) / fx_px, (v_px - cy_px) / fy_px, 1.0};
}

std::optional<Circle> PinholeCamera::project_sphere(const Eigen::Vector3d& d, double radius_m) const {
  // Rays x that touch the sphere satisfy x' M x = 0 with M = d d' - (|d|^2 - R^2) I.
  const double k = d.squaredNorm() - radius_m * radius_m;
  if (!(k > 0.0) || !(d.z() > radius_m)) return std::nullopt;
  const Eigen::Matrix3d m = d * d.transpose() - k * Eigen::Matrix3d::Identity();
  // On the plane z = 1 the conic is q' A q + 2 b'q + c = 0 with q = (x, y).
  const Eigen::Matrix2d a = m.topLeftCorner<2, 2>();
  const Eigen::Vector2d b = m.topRightCorner<2, 1>();
  const double det = a.determinant();
  if (!(det > 0.0)) return std::nullopt;  // not an ellipse
  const Eigen::Vector2d centre = -a.inverse() * b;
  const double level = m(2, 2) + b.dot(centre);                  // value of the conic at its centre
  const double area_over_pi = std::abs(level) / std::sqrt(det);  // = product of the semi-axes
  return Circle{cx_px + fx_px * centre.x(), cy_px + fy_px * centre.y(),
                std::sqrt(area_over_pi * fx_px * fy_px)};
}

Eigen::Vector2d PinholeCamera::rotational_flow_px_s(double u_px, double v_px,
                                                    const Eigen::Vector3d& w) const {
  const double x = (u_px - cx_px) / fx_px;
  const double y = (v_px - cy_px) / fy_px;
  return {fx_px * (-w.y() * (1.0 + x * x) + w.x() * x * y + w.z() * y),
          fy_px * (w.x() * (1.0 + y * y) - w.y() * x * y - w.z() * x)};
}

void describe(FieldVisitor& v, PinholeCamera& camera) {
  std::int64_t width = camera.size.width;
  std::int64_t height = camera.size.height;
  v.integer("width_px", width, {8, 2048}, "image width");
  v.integer("height_px", height, {8, 2048}, "image height");
  camera.size = {static_cast<int>(width), static_cast<int>(height)};
  v.real("fx_px", camera.fx_px, {1.0, 1e5}, "focal length along x");
  v.real("fy_px", camera.fy_px, {1.0, 1e5}, "focal length along y");
  v.real("cx_px", camera.cx_px, {-1e4, 1e4}, "principal point, x");
  v.real("cy_px", camera.cy_px, {-1e4, 1e4}, "principal point, y");
}

}  // namespace saccade
