#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <unistd.h>

#include <cmath>
#include <mutex>

#include "config/warnings.h"
#include "head/head_config.h"
#include "python/arrays.h"
#include "python/keys.h"
#include "python/module.h"
#include "python/object_parts.h"
#include "python/simulation.h"
#include "session/scenario_loop.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

/// What scenarios can name.
Registry simulation_registry(const ObjectParts& parts) {
  Registry registry{all_detectors(), all_controllers(), built_in_gates(), built_in_formats(), {}};
  parts.add_to(registry.detectors);
  parts.add_to(registry.controllers);
  return registry;
}

ObjectParts parts_of(const py::dict& detectors, const py::object& controller) {
  ObjectParts parts;
  for (const auto& [name, object] : detectors)
    parts.detectors.emplace_back(name.cast<std::string>(),
                                 shared_object(py::reinterpret_borrow<py::object>(object)));
  if (!controller.is_none()) parts.controller = shared_object(controller);
  return parts;
}

/// A scenario file, or keys that came from Python where `yaml` is given; then `folder` is that of files that they name.
Scenario scenario_of(const std::filesystem::path& path, const std::optional<std::string>& yaml,
                     const std::vector<std::string>& assignments, std::optional<std::int64_t> seed,
                     const Registry& registry) {
  if (!yaml) return read_scenario(path, assignments, seed, registry);
  YamlTree tree = tree_of(*yaml, "scenario");
  for (const std::string& assignment : assignments) set_value(tree, assignment);
  if (seed) set_value(tree, "seed=" + std::to_string(*seed));
  return read_scenario(std::move(tree), path, registry);
}

/// In a process that was forked from the one that made a simulation, the threads are missing that its end would wait for:
/// the simulation stays in memory there.
class DeleteWhereMade {
 public:
  void operator()(Simulation* simulation) const {
    if (::getpid() == made_in_) delete simulation;
  }

 private:
  pid_t made_in_ = ::getpid();
};
using SimulationHolder = std::unique_ptr<Simulation, DeleteWhereMade>;

SimulationHolder make_simulation(const std::filesystem::path& path, const std::optional<std::string>& yaml,
                                 const std::vector<std::string>& assignments,
                                 std::optional<std::int64_t> seed, bool closed_loop,
                                 const py::dict& detectors, const py::object& controller) {
  const ObjectParts parts = parts_of(detectors, controller);
  Scenario scenario = scenario_of(path, yaml, assignments, seed, simulation_registry(parts));
  static std::once_flag first;  // the renderer reads it once in a process
  std::call_once(first, [&] { set_rasterisers(scenario.run.threads); });
  const py::gil_scoped_release others_run;
  return SimulationHolder(new Simulation(std::move(scenario), closed_loop, parts.errors));
}

/// What a scenario says before its world is made: a process may ask for it that later forks.
py::dict outline(const std::filesystem::path& path, const std::optional<std::string>& yaml,
                 const std::vector<std::string>& assignments, std::optional<std::int64_t> seed,
                 const py::dict& detectors, const py::object& controller) {
  const Scenario scenario =
      scenario_of(path, yaml, assignments, seed, simulation_registry(parts_of(detectors, controller)));
  const std::shared_ptr<const HeadModel> head = head_model(scenario.sim.world.head);
  std::vector<std::string> names;
  JointVector min_rad = JointVector::Zero();
  JointVector max_rad = JointVector::Zero();
  JointVector speed_rad_s = JointVector::Zero();
  for (const HeadJoint& joint : head->joints) {
    names.push_back(joint.name);
    min_rad[joint.slot] = joint.min_rad;
    max_rad[joint.slot] = joint.max_rad;
    speed_rad_s[joint.slot] = joint.max_speed_rad_s;
  }
  py::dict dict;
  dict["name"] = scenario.name;
  dict["seed"] = scenario.seed;
  dict["duration_us"] = std::llround(scenario.run.duration_s * 1e6);
  dict["size"] = py::make_tuple(scenario.sim.camera.size.width, scenario.sim.camera.size.height);
  dict["both_eyes"] = scenario.sim.both_eyes();
  dict["joint_names"] = names;
  dict["torso_joints"] = head->torso_joints();
  dict["min_rad"] = head->in_order(min_rad);
  dict["max_rad"] = head->in_order(max_rad);
  JointLimits limits;
  limits.head = head;
  limits.min_rad = min_rad;
  limits.max_rad = max_rad;
  limits.max_speed_rad_s = speed_rad_s;
  const MotionLimits motion = motion_limits(limits, scenario.gaze.controller.limits);
  dict["reference_min_rad"] = head->gaze_in_order(motion.min_rad);
  dict["reference_max_rad"] = head->gaze_in_order(motion.max_rad);
  dict["reference_speed_rad_s"] = head->gaze_in_order(motion.speed_rad_s);
  dict["yaml"] = resolved_scenario(scenario);
  return dict;
}

py::array draw_scene(Simulation& simulation, int width, int height) {
  py::array_t<std::uint8_t> image({height, width, 3});
  simulation.draw_scene({width, height},
                        std::span(image.mutable_data(), static_cast<std::size_t>(image.size())));
  return image;
}

std::string status_text(TargetStatus status) {
  switch (status) {
    case TargetStatus::none:
      return "none";
    case TargetStatus::ok:
      return "ok";
    case TargetStatus::not_finite:
      return "not_finite";
    case TargetStatus::bad_radius:
      return "bad_radius";
    case TargetStatus::too_near:
      return "too_near";
    case TargetStatus::behind:
      return "behind";
    case TargetStatus::too_far:
      return "too_far";
    case TargetStatus::in_body:
      return "in_body";
  }
  return {};
}

py::object circle_of(const std::optional<Circle>& circle) {
  if (!circle) return py::none();
  return py::make_tuple(circle->x_px, circle->y_px, circle->r_px);
}

py::dict eye_truth(const EyeTruth& eye) {
  py::dict dict;
  dict["circle"] = circle_of(eye.circle);
  dict["visible"] = eye.visible;
  dict["root_from_camera"] = Eigen::Matrix4d(eye.root_from_cam.matrix());
  return dict;
}

py::dict truth_of(const Simulation& simulation) {
  const SimTruth& truth = simulation.robot().truth();
  py::dict dict;
  dict["t_us"] = truth.t_us;
  dict["events_until_us"] = truth.events_until_us;
  dict["ball_m"] = truth.ball_m;
  dict["joints_rad"] = truth.plant_position_rad;
  dict["left"] = eye_truth(truth.left);
  if (truth.right) dict["right"] = eye_truth(*truth.right);
  return dict;
}

py::dict detectors_of(const Simulation& simulation) {
  py::dict dict;
  for (const auto& [name, estimate] : simulation.detectors()) {
    dict[py::str(name)] = estimate.valid ? py::cast(estimate) : py::none();
  }
  return dict;
}

}  // namespace

void add_simulation(py::module_& m) {
  m.def("outline", &outline, py::arg("scenario"), py::arg("keys"), py::arg("overrides"), py::arg("seed"),
        py::arg("detectors"), py::arg("controller"));
  py::class_<Simulation, SimulationHolder>(m, "Simulation")
      .def(py::init(&make_simulation), py::arg("scenario"), py::arg("keys"), py::arg("overrides"),
           py::arg("seed"), py::arg("closed_loop"), py::arg("detectors"), py::arg("controller"))
      .def("step", &Simulation::step, py::arg("ticks"), py::call_guard<py::gil_scoped_release>())
      .def("draw_scene", &draw_scene, py::arg("width"), py::arg("height"))
      .def(
          "command",
          [](Simulation& s, const Eigen::VectorXd& reference_rad) {
            return s.command(s.robot().limits().head->gaze_by_slot(reference_rad));
          },
          py::arg("action"))
      .def(
          "look_at",
          [](Simulation& s, const Eigen::Vector3d& target_m) { return status_text(s.look_at(target_m)); },
          py::arg("action"))
      .def("take_events", [](Simulation& s) { return array_of(s.take_events()); })
      .def("detectors", &detectors_of)
      .def("truth", &truth_of)
      .def("root_from_camera",
           [](const Simulation& s, bool right) {
             const MountedCamera& assumed = right ? s.scenario().right_calibration : s.scenario().calibration;
             const CameraMotion motion =
                 camera_motion(s.robot().limits().head->chain, s.head(), right ? Eye::right : Eye::left,
                               assumed.mount.eye_from_camera());
             return Eigen::Matrix4d(motion.root_from_camera.matrix());
           })
      .def("camera",
           [](const Simulation& s, bool right) {
             return right ? s.scenario().right_calibration.camera : s.scenario().calibration.camera;
           })
      .def("camera_motion",
           [](const Simulation& s) {
             return camera_motion(s.robot().limits().head->chain, s.head(), Eye::left,
                                  s.scenario().calibration.mount.eye_from_camera());
           })
      .def_property_readonly("t_us", [](const Simulation& s) { return s.robot().now_us(); })
      .def_property_readonly(
          "duration_us", [](const Simulation& s) { return std::llround(s.scenario().run.duration_s * 1e6); })
      .def_property_readonly("name", [](const Simulation& s) { return s.scenario().name; })
      .def_property_readonly("seed", [](const Simulation& s) { return s.scenario().seed; })
      .def_property_readonly("both_eyes", [](const Simulation& s) { return s.scenario().sim.both_eyes(); })
      .def_property_readonly("joint_names",
                             [](const Simulation& s) {
                               std::vector<std::string> names;
                               for (const HeadJoint& joint : s.robot().limits().head->joints)
                                 names.push_back(joint.name);
                               return names;
                             })
      .def_property_readonly("torso_joints",
                             [](const Simulation& s) { return s.robot().limits().head->torso_joints(); })
      .def_property_readonly(
          "position_rad",
          [](const Simulation& s) { return s.robot().limits().head->in_order(s.head().position_rad); })
      .def_property_readonly(
          "velocity_rad_s",
          [](const Simulation& s) { return s.robot().limits().head->in_order(s.head().velocity_rad_s); })
      .def_property_readonly("limits_rad",
                             [](const Simulation& s) {
                               const JointLimits limits = s.robot().limits();
                               return std::pair(limits.head->in_order(limits.min_rad),
                                                limits.head->in_order(limits.max_rad));
                             })
      .def_property_readonly("reference_rad",
                             [](const Simulation& s) -> std::optional<Eigen::VectorXd> {
                               if (!s.reference_rad()) return std::nullopt;
                               return s.robot().limits().head->gaze_in_order(*s.reference_rad());
                             })
      .def_property_readonly("target_m",
                             [](const Simulation& s) { return std::optional<Eigen::Vector3d>(s.target_m()); })
      .def_property_readonly("yaml", [](const Simulation& s) { return resolved_scenario(s.scenario()); });
}

}  // namespace saccade::python
