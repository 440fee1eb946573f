#include "apps/config/robot_file.h"

#include <algorithm>

#include "apps/config/scenario.h"
#include "apps/config/yaml_reader.h"
#include "apps/config/yaml_writer.h"
#include "recording/format_registry.h"

namespace saccade {
namespace {

void describe(FieldVisitor& v, RobotFile::Recording& recording) {
  v.text("path", recording.path, "event file, or run folder with joints");
  v.real("speed", recording.speed, {0.01, 100.0}, "of the recording's time against ours");
}

void describe(FieldVisitor& v, RobotFile::Deploy& deploy) {
  v.real("tick_ms", deploy.tick_ms, {0.5, 20.0}, "from one tick to the next");
  v.real("ramp_in_s", deploy.ramp_in_s, {0.0, 60.0},
         "after activation: the speed limit grows to its full value, a gaze controller gets no target");
  v.integer("max_events_per_tick", deploy.max_events_per_tick, {1, 1e6},
            "that detectors get; the oldest ones above it are left out");
  v.real("shadows_until_ms", deploy.shadows_until_ms, {0.0, 20.0},
         "into a tick, detectors that do not drive are asked");
  v.section(
      "watchdog", [&](FieldVisitor& w) { saccade::describe(w, deploy.watchdog); }, "what stops the head");
}

}  // namespace

void describe(FieldVisitor& v, RobotFile& r) {
  describe_name(v, r.name, "of the robot, in reports and in the name of the run folder");
  v.text("description", r.description, "what it is, in a sentence");
  v.choice("backend", r.backend, {"recording", "yarp"}, "what stands for the robot");
  if (r.backend == "recording") {
    v.section(
        "recording", [&](FieldVisitor& w) { describe(w, r.recording); }, "what is played as if it were one");
  } else if (r.backend == "yarp") {
    v.section(
        "yarp", [&](FieldVisitor& w) { saccade::describe(w, r.yarp); }, "where it is on a YARP network");
  }
  v.section(
      "calibration", [&](FieldVisitor& w) { describe_calibration(w, r.calibration); },
      "the left camera as detectors and gaze assume it");
  v.section(
      "limits", [&](FieldVisitor& w) { saccade::describe(w, r.limits); },
      "of the head's joints, whatever its own are");
  describe_detectors(v, r.detectors);
  v.section(
      "gaze",
      [&](FieldVisitor& w) {
        std::vector<std::string> drivers = {"none"};
        for (const auto& [name, config] : r.detectors) drivers.push_back(name);
        w.choice("detector", r.gaze.detector, drivers, "which of the detectors drives the head");
        saccade::describe(w, r.gaze.gate);
        saccade::describe(w, r.gaze.follow);
        if (r.has_own_controller()) {
          w.require(r.gaze.follow.lost == WhenLost::hold, "lost", word_of(r.gaze.follow.lost),
                    "hold: the robot's gaze controller has no rest");
          return;
        }
        saccade::describe(w, r.gaze.controller);
        w.require(r.gaze.controller.follows_targets(), "controller", r.gaze.controller.controller,
                  "qp or ikingaze, which follow the ball");
      },
      "from detections to gaze");
  v.section(
      "deploy", [&](FieldVisitor& w) { describe(w, r.deploy); }, "time, safety and overload");
  v.section(
      "output",
      [&](FieldVisitor& w) {
        w.choice("events", r.output.events, built_in_formats().run_choices(true), "format of the event file");
      },
      "what the run folder holds");
}

namespace {

/// Where a file that the robot file names lies, from anywhere.
std::string resolved_path(const YamlTree& tree, const std::filesystem::path& folder, const char* key,
                          const std::string& path) {
  const YamlNode* node = tree.root.find(key);
  const bool relative_to_file = node != nullptr && node->mark.line > 0;
  const std::filesystem::path found = relative_to_file ? folder / path : std::filesystem::path(path);
  return std::filesystem::absolute(found).lexically_normal().string();
}

}  // namespace

RobotFile read_robot_file(const std::filesystem::path& path, const std::vector<std::string>& assignments,
                          const Registry& registry) {
  YamlTree tree = read_yaml_file(path);
  for (const std::string& assignment : assignments) set_value(tree, assignment);
  std::vector<std::string> required = {"name", "backend", "calibration", "detectors"};
  if (const YamlNode* backend = tree.root.find("backend"); backend != nullptr && backend->text == "recording")
    required.insert(required.end(), {"recording", "recording.path"});
  RobotFile robot;
  robot.gaze.controller = registry.controllers.config();
  robot.gaze.gate = registry.gates.config();
  robot.detectors = named_detectors_in(tree, registry.detectors, required);
  if (tree.root.find("calibration.file") == nullptr) {
    for (const char* key :
         {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2"})
      required.push_back(std::string("calibration.") + key);
  }
  YamlReader reader(tree, std::move(required), path.parent_path().string());
  describe(reader, robot);
  reader.finish();
  if (robot.backend == "recording")
    robot.recording.path = resolved_path(tree, path.parent_path(), "recording.path", robot.recording.path);
  return robot;
}

std::string resolved_robot_file(const RobotFile& robot) {
  RobotFile copy = robot;
  YamlWriter writer;
  describe(writer, copy);
  return writer.yaml();
}

}  // namespace saccade
