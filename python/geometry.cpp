#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <limits>

#include "config/cameras.h"
#include "control/head_kinematics.h"
#include "core/camera.h"
#include "head/icub_cameras.h"
#include "python/arrays.h"
#include "python/keys.h"
#include "python/module.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Pixels = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Eye eye_of(const std::string& name) {
  if (name == "left") return Eye::left;
  if (name == "right") return Eye::right;
  throw InputError("eye", name, "left or right");
}

Pixels project(const Camera& camera, const Eigen::Ref<const Points>& points_m) {
  Pixels pixels(points_m.rows(), 2);
  for (Eigen::Index i = 0; i < points_m.rows(); ++i)
    pixels.row(i) =
        camera.project(points_m.row(i).transpose()).value_or(Eigen::Vector2d(nan, nan)).transpose();
  return pixels;
}

Points rays(const Camera& camera, const Eigen::Ref<const Pixels>& pixels) {
  Points rays(pixels.rows(), 3);
  for (Eigen::Index i = 0; i < pixels.rows(); ++i)
    rays.row(i) = camera.ray(pixels(i, 0), pixels(i, 1)).transpose();
  return rays;
}

std::optional<std::tuple<double, double, double>> project_sphere(const Camera& camera,
                                                                 const Eigen::Vector3d& centre_m,
                                                                 double radius_m) {
  const auto circle = camera.project_sphere(centre_m, radius_m);
  if (!circle) return std::nullopt;
  return std::tuple(circle->x_px, circle->y_px, circle->r_px);
}

HeadState state_of(const Eigen::VectorXd& position_rad, const Eigen::VectorXd& velocity_rad_s) {
  HeadState state;
  state.position_rad = default_head()->by_slot(position_rad);
  state.velocity_rad_s = default_head()->by_slot(velocity_rad_s);
  return state;
}

HeadKinematics head_at(const Eigen::VectorXd& position_rad) {
  return {default_head()->chain, default_head()->by_slot(position_rad)};
}

}  // namespace

void add_geometry(py::module_& m) {
  m.attr("joint_names") = py::cast(std::vector<std::string>(joint_names.begin(), joint_names.end()));
  py::class_<Camera>(m, "Camera", "A pinhole behind a lens, in OpenCV's convention (docs/conventions.md).")
      .def_property_readonly("size", [](const Camera& c) { return std::pair(c.size.width, c.size.height); })
      .def_readonly("fx_px", &Camera::fx_px)
      .def_readonly("fy_px", &Camera::fy_px)
      .def_readonly("cx_px", &Camera::cx_px)
      .def_readonly("cy_px", &Camera::cy_px)
      .def_readonly("k1", &Camera::k1)
      .def_readonly("k2", &Camera::k2)
      .def_readonly("p1", &Camera::p1)
      .def_readonly("p2", &Camera::p2)
      .def_property_readonly("lens", [](const Camera& c) { return std::string(word_of(c.lens)); })
      .def_readonly("k3", &Camera::k3)
      .def_readonly("k4", &Camera::k4)
      .def("project", &project, py::arg("points_m"),
           "Pixels (N, 2) of points (N, 3) in the camera frame; NaN where the camera does not show a point.")
      .def("rays", &rays, py::arg("pixels"), "Points (N, 3) at unit depth on the rays through pixels (N, 2).")
      .def("project_sphere", &project_sphere, py::arg("centre_m"), py::arg("radius_m"),
           "The circle (x, y, r) that stands for the outline of a sphere; None where it is not in the image "
           "plane.");
  m.def("camera", [](const std::string& yaml) { return config_of(yaml, "camera", icub_left_2016); });
  m.def(
      "pinhole_camera",
      [](const std::pair<std::int64_t, std::int64_t>& size) { return pinhole_camera(image_size_of(size)); },
      py::arg("size"));
  m.def(
      "camera_of_size",
      [](const std::pair<std::int64_t, std::int64_t>& size) {
        Camera camera = icub_left_2016;  // what `saccade detect` assumes of a bare recording
        camera.size = image_size_of(size);
        return camera;
      },
      py::arg("size"));
  py::class_<CameraMotion>(m, "CameraMotion", "Pose and velocity of a camera at one instant.")
      .def_property_readonly(
          "root_from_camera",
          [](const CameraMotion& motion) { return Eigen::Matrix4d(motion.root_from_camera.matrix()); })
      .def_readonly("linear_velocity_m_s", &CameraMotion::linear_velocity_m_s,
                    "Of the pinhole, camera frame.")
      .def_readonly("angular_velocity_rad_s", &CameraMotion::angular_velocity_rad_s, "Camera frame.");
  m.def(
      "camera_motion",
      [](const Eigen::VectorXd& position_rad, const Eigen::VectorXd& velocity_rad_s, const std::string& eye) {
        return camera_motion(default_head()->chain, state_of(position_rad, velocity_rad_s), eye_of(eye));
      },
      py::arg("joints"), py::arg("velocities"), py::arg("eye"));
  m.def(
      "root_from_eye",
      [](const Eigen::VectorXd& position_rad, const std::string& eye) {
        return Eigen::Matrix4d(head_at(position_rad).root_from_eye(eye_of(eye)).matrix());
      },
      py::arg("joints"), py::arg("eye"));
  m.def(
      "fixation_point",
      [](const Eigen::VectorXd& position_rad) -> std::optional<Eigen::Vector3d> {
        const FixationPoint point = head_at(position_rad).fixation();
        return point.valid ? std::optional(point.point_m) : std::nullopt;
      },
      py::arg("joints"));
}

}  // namespace saccade::python
