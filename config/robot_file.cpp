#include "config/robot_file.h"

#include <algorithm>

#include "config/head_section.h"
#include "config/scenario.h"
#include "config/yaml_reader.h"
#include "config/yaml_writer.h"

namespace saccade {
namespace {

void describe(FieldVisitor& v, RobotFile::Deploy& deploy) {
  v.real("tick_ms", deploy.tick_ms, {0.5, 20.0}, "period of the ticks");
  v.real("ramp_in_s", deploy.ramp_in_s, {0.0, 60.0},
         "time after activation in which the speed limit rises to its full value; a robot's own gaze "
         "controller gets no target "
         "in it");
  v.real("activate_within_s", deploy.activate_within_s, {0.0, 3600.0},
         "time for which --activate repeats a failed activation; then the run ends");
  v.real("edge_check_s", deploy.edge_check_s, {0.0, 60.0},
         "time in which a start-up check waits for a brighter edge to be moved into the image, to see that "
         "ON means brighter; 0: no such check");
  v.choice("guard", deploy.guard,
           "saccade guard: required to activate the head (its loss stops the head), used if it is there, or "
           "ignored");
  v.integer("max_events_per_tick", deploy.max_events_per_tick, {1, 1e6},
            "most events of a tick that detectors process; older ones are dropped");
  v.real("shadows_until_ms", deploy.shadows_until_ms, {0.0, 20.0},
         "time from the start of a tick up to which detectors that do not drive the head run");
  v.section(
      "watchdog", [&](FieldVisitor& w) { saccade::describe(w, deploy.watchdog); }, "what stops the head");
}

}  // namespace

RobotFile empty_robot_file(const Registry& registry) {
  RobotFile file;
  file.robot = registry.backends.config();
  file.gaze.controller = registry.controllers.config();
  file.gaze.gate = registry.gates.config();
  file.output.formats = registry.formats;
  return file;
}

RobotContext robot_context(const RobotFile& file) {
  return {joint_limits(file.limits), file.calibration.camera.size, file.output.formats};
}

void describe(FieldVisitor& v, RobotFile& r) {
  describe_name(v, r.name, "name of the robot, in reports and of the run folder");
  v.text("description", r.description, "the robot, in a sentence");
  describe(v, r.robot);
  v.section(
      "calibration", [&](FieldVisitor& w) { describe_calibration(w, r.calibration, 0); },
      "assumed calibration of the left camera");
  v.section(
      "head", [&](FieldVisitor& w) { describe_head(w, r.head); }, "the robot's head");
  if (v.fills_defaults()) r.limits = HeadLimitsConfig(valid_head(r.head));
  v.section(
      "limits", [&](FieldVisitor& w) { saccade::describe(w, r.limits); },
      "limits of the head's joints, in addition to those of the robot");
  describe_detectors(v, r.detectors);
  v.section(
      "gaze",
      [&](FieldVisitor& w) {
        std::vector<std::string> drivers = {"none"};
        for (const auto& [name, config] : r.detectors) drivers.push_back(name);
        w.choice("detector", r.gaze.detector, drivers,
                 "detector that drives the head; none: the head is not moved");
        saccade::describe(w, r.gaze.gate);
        saccade::describe(w, r.gaze.follow);
        w.require(!r.gaze.follow.stabilisation.gyroscope, "stabilisation.gyroscope", "true",
                  "false: the inertial sensor of a robot is not read");
        if (r.robot.has_gaze_controller()) {
          w.require(r.gaze.follow.lost != WhenLost::rest, "lost", word_of(r.gaze.follow.lost),
                    "hold or search: the robot's gaze controller has no rest");
          return;
        }
        saccade::describe(w, r.gaze.controller);
        w.require(r.gaze.controller.follows_targets(), "controller", r.gaze.controller.controller,
                  "qp or ikingaze, which follow the ball");
      },
      "detector, gate and gaze controller");
  v.section(
      "deploy",
      [&](FieldVisitor& w) {
        describe(w, r.deploy);
        w.require(r.deploy.guard != GuardUse::required || !r.robot.head_name().empty(), "guard", "required",
                  "optional or none: no other process can stop the head of this backend");
      },
      "timing, safety and overload");
  v.section(
      "output",
      [&](FieldVisitor& w) {
        w.choice("events", r.output.events, r.output.formats.run_choices(true), "format of the event file");
        w.integer("rotate_mb", r.output.rotate_mb, {1, 1e6},
                  "size of a recorded event file from which on the next one follows");
        w.real("rotate_s", r.output.rotate_s, {1.0, 1e6}, "longest duration of a recorded event file");
        w.integer("least_free_mb", r.output.least_free_mb, {0, 1e7},
                  "with less room on the disk the recording ends, or does not begin");
      },
      "contents of the run folder");
}

RobotFile read_robot_file(const std::filesystem::path& path, const std::vector<std::string>& assignments,
                          const Registry& registry) {
  YamlTree tree = read_yaml_file(path);
  for (const std::string& assignment : assignments) set_value(tree, assignment);
  std::vector<std::string> required = {"name", "backend", "calibration", "detectors"};
  const YamlNode* const named = tree.root.find("backend");
  const RobotBackend* const backend = named != nullptr ? registry.backends.rows().find(named->text) : nullptr;
  if (backend != nullptr && !backend->required.empty()) required.push_back(backend->name);
  for (std::size_t i = 0; backend != nullptr && i < backend->required.size(); ++i)
    required.push_back(backend->name + "." + backend->required[i]);
  RobotFile robot = empty_robot_file(registry);
  robot.detectors = named_detectors_in(tree, registry.detectors, required);
  if (tree.root.find("calibration.file") == nullptr) {
    for (const char* key :
         {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2"})
      required.push_back(std::string("calibration.") + key);
  }
  YamlReader reader(tree, std::move(required), path.parent_path().string());
  describe(reader, robot);
  reader.finish();
  return robot;
}

std::string resolved_robot_file(const RobotFile& robot) {
  RobotFile copy = robot;
  YamlWriter writer;
  describe(writer, copy);
  return writer.yaml();
}

}  // namespace saccade
