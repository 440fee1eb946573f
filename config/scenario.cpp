#include "config/scenario.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "config/calibration_file.h"
#include "config/cameras.h"
#include "config/figure_path.h"
#include "config/head_section.h"
#include "config/latency_section.h"
#include "config/world_defaults.h"
#include "config/yaml_reader.h"
#include "config/yaml_writer.h"
#include "core/nearest_name.h"
#include "core/units.h"
#include "evaluation/scoring/metrics.h"
#include "head/icub_cameras.h"
#include "recording/run_file_names.h"
#include "sim/data_directory.h"

namespace saccade {
namespace {

/// The words of `key.path=value` before any of `ends`.
std::string key_of(const std::string& assignment, const char* ends) {
  return assignment.substr(0, assignment.find_first_of(ends));
}

/// A metrics.json of this scenario with nothing in it: which figures there are.
nlohmann::json empty_metrics(const Scenario& scenario) {
  Metrics metrics;
  DetectorScore score;
  score.streaming.emplace();
  score.nees.emplace();
  for (const auto& [name, config] : scenario.detectors) metrics.detectors.emplace_back(name, score);
  if (scenario.frame_30hz) metrics.detectors.emplace_back(frame_detector_name, score);
  if (scenario.gaze.detector != "none") metrics.gaze.emplace();
  if (scenario.sim.both_eyes()) metrics.right_eye.emplace();
  if (scenario.latency.kind != LatencyKind::none) {
    LatencyMetrics& latency = metrics.latency.emplace();
    for (const auto& [name, config] : scenario.detectors) latency.detectors.push_back({name, 0.0, 0});
  }
  if (scenario.sim.labels) {
    metrics.clutter = ClutterCounter().share();
    for (auto& [name, scored] : metrics.detectors) scored.clutter.emplace();
  }
  return nlohmann::json::parse(metrics_to_json(metrics));
}

void describe_expect(FieldVisitor& v, Scenario& scenario) {
  const nlohmann::json metrics = empty_metrics(scenario);
  describe_expectations(v, scenario.expect,
                        [&](const std::string& path) { return find_figure(metrics, path) != nullptr; });
}

void describe_frame_detector(FieldVisitor& v, Scenario& s) {
  v.optional_section(frame_detector_name, s.frame_30hz, "a conventional camera and its detector");
  if (!s.frame_30hz) return;
  const bool taken = std::any_of(s.detectors.begin(), s.detectors.end(),
                                 [](const auto& named) { return named.first == frame_detector_name; });
  v.require(!taken, "detectors", std::string(frame_detector_name),
            "other names: this one is the frame camera's");
}

/// A camera with values out of range is reported in its own block; its calibration starts from a pinhole then.
MountedCamera calibration_default(const MountedCamera& mounted) {
  FieldChecker checker("camera");
  Camera copy = mounted.camera;
  describe(checker, copy);
  return checker.passed() ? mounted : MountedCamera{pinhole_camera(mounted.camera.size), mounted.mount};
}

/// `side`: 0 for the left, 1 for the right camera.
void describe_calibration(FieldVisitor& v, MountedCamera& calibration, const MountedCamera& camera,
                          int side) {
  if (v.fills_defaults()) calibration = calibration_default(camera);
  describe_calibration(v, calibration, side);
  v.require(calibration.camera.size == camera.camera.size, "width_px", in_words(calibration.camera.size),
            "the camera's image, " + in_words(camera.camera.size));
}

/// The block `detectors` of a file in `folder`, with assignments as of read_detectors().
NamedDetectors detectors_of(const YamlTree& file, const std::string& folder,
                            const std::vector<std::string>& assignments, const DetectorRegistry& registry) {
  const YamlNode* block = file.root.find("detectors");
  const std::vector<std::string> names = block != nullptr ? block->keys : std::vector<std::string>{};
  const auto is_for_one = [&](const std::string& assignment) {
    return std::find(names.begin(), names.end(), key_of(assignment, ".=")) != names.end();
  };
  const auto with_sets = [&](const auto& takes) {
    YamlTree tree = file;
    for (const std::string& assignment : assignments) {
      if (is_for_one(assignment)) {
        set_value(tree, "detectors." + assignment);
        continue;
      }
      for (const std::string& name : names) {
        if (takes(name, assignment))
          set_value(tree, std::string("detectors.").append(name).append(".").append(assignment));
      }
    }
    return tree;
  };
  // Which keys a detector has may depend on what is set, so they are known once everything is.
  const YamlTree everything = with_sets([](const auto&...) { return true; });
  std::vector<std::string> required = {"detectors"};
  NamedDetectors detectors = named_detectors_in(everything, registry, required);
  YamlReader first(everything, {}, folder);
  describe_detectors(first, detectors);
  const KeyValues keys = keys_of_detectors(detectors);
  const auto has = [&](const std::string& name, const std::string& assignment) {
    return keys.has("detectors." + name + "." + key_of(assignment, "="));
  };
  std::vector<Problem> slips;
  for (const std::string& assignment : assignments) {
    const std::string word = key_of(assignment, ".=");
    const bool is_key = std::ranges::any_of(names, [&](const std::string& name) { return has(name, word); });
    const std::string close = nearest_name(word, names);
    if (!is_for_one(assignment) && !is_key && word.size() < key_of(assignment, "=").size() && !close.empty())
      slips.push_back(
          {"--set " + assignment, word, "a detector's name or a key; did you mean " + close + "?"});
  }
  if (!slips.empty()) throw InputError(std::move(slips));
  const YamlTree tree = with_sets([&](const std::string& name, const std::string& assignment) {
    const auto has_it = [&](const std::string& other) { return has(other, assignment); };
    return has(name, assignment) || std::none_of(names.begin(), names.end(), has_it);
  });
  required = {"detectors"};
  detectors = named_detectors_in(tree, registry, required);
  YamlReader reader(tree, std::move(required), folder);
  describe_detectors(reader, detectors);
  reader.finish();
  return detectors;
}

}  // namespace

Scenario empty_scenario(const Registry& registry) {
  Scenario scenario;
  scenario.gaze.controller = registry.controllers.config();
  scenario.gaze.gate = registry.gates.config();
  scenario.output.formats = registry.formats;
  return scenario;
}

void describe(FieldVisitor& v, Scenario& s) {
  describe_name(v, s.name, "name of the scenario, in reports and of the run folder");
  v.text("description", s.description, "what happens, in a sentence");
  v.integer("seed", s.seed, {0, 9e15}, "seed of all random numbers of the run");
  v.optional_section("world", s.world, "a world drawn from the seed, whose values the other keys change");
  v.section(
      "run",
      [&](FieldVisitor& w) {
        w.real("duration_s", s.run.duration_s, {0.01, 86400.0}, "simulated time");
        w.integer("threads", s.run.threads, {1, 64}, "number of threads; the result does not depend on it");
      },
      "the run");
  v.section(
      "lab", [&](FieldVisitor& w) { describe(w, s.sim.lab); }, "the room");
  v.section(
      "head", [&](FieldVisitor& w) { describe_head(w, s.sim.world.head); }, "the robot's head");
  describe(v, s.sim.world);
  v.choice("eyes", s.sim.eyes, "eyes with a camera");
  v.require(!s.sim.both_eyes() || valid_head(s.sim.world.head)->chain.eyes > 1, "eyes", "both",
            "left: the head has one eye");
  MountedCamera left{s.sim.camera, s.sim.mount};
  v.section(
      "camera",
      [&](FieldVisitor& w) {
        describe_camera(w, left, s.camera_preset, {"icub_left_2016", icub_left_2016.size, s.drawn_camera});
      },
      "the left eye's camera");
  s.sim.camera = left.camera;
  s.sim.mount = left.mount;
  const bool of_a_kind = !camera_preset_row(s.camera_preset).emulator.empty();
  if (s.sim.both_eyes()) {
    v.section(
        "right_camera",
        [&](FieldVisitor& w) {
          describe_camera(w, s.sim.right, s.right_camera_preset,
                          of_a_kind ? CameraDefault{s.camera_preset, left.camera.size, left.camera}
                                    : CameraDefault{"icub_right_2016", left.camera.size, std::nullopt});
          w.require(s.sim.right.camera.size == left.camera.size, "width_px",
                    in_words(s.sim.right.camera.size),
                    "the left camera's image, " + in_words(left.camera.size));
        },
        "the right eye's camera, with the keys of camera");
  }
  v.section(
      "calibration", [&](FieldVisitor& w) { describe_calibration(w, s.calibration, left, 0); },
      "assumed calibration of the left camera; by default the true one");
  if (s.sim.both_eyes()) {
    v.section(
        "right_calibration",
        [&](FieldVisitor& w) { describe_calibration(w, s.right_calibration, s.sim.right, 1); },
        "assumed calibration of the right camera");
  }
  v.section(
      "render",
      [&](FieldVisitor& w) {
        w.choice("backend", s.sim.gl, GlContext::backends(),
                 "OpenGL context, without a window; auto: what the environment variable MUJOCO_GL says (egl, "
                 "osmesa), without it egl, and osmesa where that fails");
        w.integer("device", s.sim.gl_device, {-1, 63},
                  "device that EGL draws with, a GPU for example, as `saccade --version` lists them; -1: "
                  "software (llvmpipe)");
        w.require(s.sim.gl_device < 0 || s.sim.gl != "osmesa", "device", std::to_string(s.sim.gl_device),
                  "backend: egl");
        describe(w, s.sim.render);
        // Drawn images cost more than reprojected ones.
        if (w.fills_defaults() && s.sim.render.method == RenderMethod::direct)
          s.sim.sampling.max_displacement_px = 0.5;
        describe(w, s.sim.sampling);
      },
      "rendering of the eyes' images");
  if (v.fills_defaults() && of_a_kind) {
    s.sim.emulator = emulator_preset(camera_preset_row(s.camera_preset).emulator);
  }
  v.section(
      "emulator", [&](FieldVisitor& w) { describe(w, s.sim.emulator); }, "the event camera's pixels");
  describe_detectors(v, s.detectors);
  describe_frame_detector(v, s);
  // The gate assumes the target of the scenario.
  if (v.fills_defaults()) {
    s.gaze.gate.target.ball_diameter_m = s.sim.world.ball.diameter_m;
    for (const auto& [name, object] : s.sim.world.objects) {
      if (name == s.sim.world.target && object.shape == ObjectShape::sphere)
        s.gaze.gate.target.ball_diameter_m = object.size_m.y();
    }
  }
  v.section(
      "gaze",
      [&](FieldVisitor& w) {
        std::vector<std::string> drivers = {"none"};
        for (const auto& [name, config] : s.detectors) drivers.push_back(name);
        w.choice("detector", s.gaze.detector, drivers,
                 "detector that drives the head; none: the head is not moved");
        w.real("acquire_within_deg", s.gaze.acquire_within_deg, {0.1, 90.0},
               "angle between gaze and ball within which the ball counts as acquired, in the scores");
        describe(w, s.gaze.gate);
        describe(w, s.gaze.controller);
        describe(w, s.gaze.follow);
        if (s.sim.both_eyes())
          w.boolean("stereo", s.gaze.stereo,
                    "whether the distance of the ball comes from triangulation with both eyes");
        w.require(!s.gaze.follow.stabilisation.gyroscope || s.sim.world.imu.has_value(),
                  "stabilisation.gyroscope", "true", "false, for there is no section `imu`");
        w.require(s.gaze.controller.follows_targets() || s.gaze.detector == "none", "detector",
                  s.gaze.detector,
                  "none, for the controller `" + s.gaze.controller.controller + "` follows nothing");
      },
      "detector, gate and gaze controller");
  v.section(
      "latency",
      [&](FieldVisitor& w) { describe_latency(w, s.latency, s.detectors, s.frame_30hz.has_value()); },
      "how long transport, detectors, controller and actuation take");
  v.section(
      "output",
      [&](FieldVisitor& w) {
        w.boolean("video", s.output.video, "whether the run folder gets video.mp4");
        w.real("video_speed", s.output.video_speed, {0.01, 100.0},
               "time of the run per time of the video: 0.1 is slow motion, ten times slower");
        const FormatRegistry& formats = s.output.formats;
        const std::vector<std::string> fitting =
            formats.run_choices_for(s.sim.camera.size, s.sim.both_eyes() ? 2 : 1);
        const auto fits = [&] { return std::ranges::count(fitting, s.output.events) > 0; };
        if (w.fills_defaults() && !fits() && std::ranges::count(fitting, "aedat4") > 0)
          s.output.events = "aedat4";
        w.choice("events", s.output.events, formats.run_choices(), "format of the event file");
        std::string names;
        for (const std::string& name : fitting) names += (names.empty() ? "" : ", ") + name;
        w.require(fits(), "events", s.output.events,
                  "a format that holds images of this size, of both eyes where there are two: " + names);
        w.boolean("labels", s.sim.labels, "whether the run folder gets labels.csv: the cause of each event");
        w.optional_section("ground_truth", s.output.ground_truth,
                           "whether the run folder gets the ground truth of every pixel");
        if (s.output.ground_truth)
          w.require(!s.output.ground_truth->imu || s.sim.world.imu.has_value(), "ground_truth.imu", "true",
                    "false, for there is no section `imu`");
        w.integer("pictures", s.output.pictures, {0, 60},
                  "number of instants that the report shows with images");
        w.boolean("eye_movements", s.output.eye_movements,
                  "whether metrics.json and the report get figures of eye movements: gain, phase, latency, "
                  "saccades, "
                  "image motion");
      },
      "contents of the run folder");
  describe_expect(v, s);
}

Scenario read_scenario(const std::filesystem::path& path, const std::vector<std::string>& assignments,
                       std::optional<std::int64_t> seed, const Registry& registry) {
  const std::filesystem::path file = shipped_file(path);
  YamlTree tree = read_yaml_file(file);
  for (const std::string& assignment : assignments) set_value(tree, assignment);
  if (seed) set_value(tree, "seed=" + std::to_string(*seed));
  return read_scenario(std::move(tree), file.parent_path(), registry);
}

std::filesystem::path scenario_file(const std::filesystem::path& folder, const std::filesystem::path& name) {
  std::error_code ignored;
  std::filesystem::path beside = folder / name;
  if (std::filesystem::exists(beside, ignored)) return beside;
  const std::filesystem::path shipped = shipped_file(name);
  return shipped != name ? shipped : beside;
}

Scenario read_scenario(YamlTree tree, const std::filesystem::path& folder, const Registry& registry) {
  std::vector<std::string> required = {"name", "detectors"};
  Scenario scenario = empty_scenario(registry);
  scenario.detectors = named_detectors_in(tree, registry.detectors, required);
  scenario.expect = expectations_in(tree);
  if (tree.root.find("world") != nullptr) {
    draw_defaults(tree, folder.string(), scenario);
  } else {
    required.insert(required.end(), {"run", "run.duration_s"});
    const YamlNode* const target = tree.root.find("target");
    if (target == nullptr || target->text == "ball")
      required.insert(required.end(), {"ball", "ball.trajectory"});
  }
  YamlReader reader(tree, std::move(required), folder.string());
  describe(reader, scenario);
  reader.finish();
  return scenario;
}

std::string resolved_scenario(const Scenario& scenario) {
  Scenario copy = scenario;
  YamlWriter writer;
  describe(writer, copy);
  return writer.yaml();
}

bool has_figure(const Scenario& scenario, const std::string& path) {
  return find_figure(empty_metrics(scenario), path) != nullptr;
}

std::vector<std::string> unmet_expectations(const Scenario& scenario, const Metrics& metrics) {
  std::vector<std::string> unmet;
  for (const JudgedExpectation& judged : judge(scenario.expect, metrics)) {
    if (!judged.met()) unmet.push_back("expect: " + judged.text());
  }
  return unmet;
}

NamedDetectors read_detectors(const std::filesystem::path& path, const std::vector<std::string>& assignments,
                              const DetectorRegistry& registry) {
  YamlTree file;
  if (!path.empty()) {
    file = read_yaml_file(path);
  } else {
    for (const std::string& name : registry.defaults) set_value(file, "detectors." + name + "={}");
  }
  return detectors_of(file, path.parent_path().string(), assignments, registry);
}

std::optional<RecordedDetectors> read_recorded_detectors(const std::filesystem::path& folder,
                                                         const std::vector<std::string>& assignments,
                                                         const DetectorRegistry& registry) {
  for (const char* const name : {run_file::detectors, run_file::scenario, run_file::robot}) {
    const std::filesystem::path path = folder / name;
    if (!std::filesystem::exists(path)) continue;
    const std::optional<YamlTree> block = block_of(read_yaml_file(path), "detectors");
    if (!block || block->root.items.front().keys.empty()) return std::nullopt;
    return RecordedDetectors{path, detectors_of(*block, folder.string(), assignments, registry)};
  }
  return std::nullopt;
}

KeyValues keys_of_detectors(NamedDetectors detectors) {
  KeyValues keys;
  describe_detectors(keys, detectors);
  return keys;
}

std::string resolved_detectors(NamedDetectors detectors) {
  YamlWriter writer;
  describe_detectors(writer, detectors);
  return writer.yaml();
}

MountedCamera read_calibration(const std::filesystem::path& path, int camera) {
  const YamlTree tree = read_calibration_file(path, camera);
  const std::string block = "calibration";
  std::vector<std::string> required = {block};
  for (const char* key :
       {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k4"})
    required.push_back(block + "." + key);
  if (const YamlNode* const written = tree.root.entry(block);
      written != nullptr && written->entry("lens") != nullptr &&
      written->entry("lens")->text == word_of(LensModel::fisheye))
    required.push_back(block + ".k3");
  YamlReader reader(tree, std::move(required));
  Calibration calibration;
  describe(reader, calibration);
  reader.finish();
  return calibration.camera;
}

std::string calibration_yaml(Calibration calibration) {
  YamlWriter writer;
  describe(writer, calibration);
  return writer.yaml();
}

EmulatorConfig read_emulator(const std::filesystem::path& path, const std::vector<std::string>& assignments) {
  const std::string block = "emulator", prefix = block + ".";
  YamlTree tree = path.empty() ? YamlTree{} : read_yaml_file(path);
  const bool in_block = tree.root.keys == std::vector<std::string>{block};
  for (const std::string& assignment : assignments) {
    const std::string key = assignment.starts_with(prefix) ? assignment.substr(prefix.size()) : assignment;
    set_value(tree, in_block ? std::string(prefix).append(key) : key);
  }
  YamlReader reader(tree);
  EmulatorConfig config;
  if (in_block) {
    reader.section(
        block, [&](FieldVisitor& v) { describe(v, config); }, "the event camera's pixels");
  } else {
    describe(reader, config);
  }
  reader.finish();
  return config;
}

}  // namespace saccade
