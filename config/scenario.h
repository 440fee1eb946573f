#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/expectations.h"
#include "config/key_values.h"
#include "config/registry.h"
#include "config/sections.h"
#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "control/gaze_controller.h"
#include "evaluation/calibration/calibration.h"
#include "evaluation/frame_camera/frame_detector.h"
#include "evaluation/scoring/metrics.h"
#include "head/icub_cameras.h"
#include "loop/latency.h"
#include "sim/ground_truth_config.h"
#include "sim/sim_robot.h"
#include "worlds/random_world.h"

namespace saccade {

/// A closed-loop run, as a scenario file describes it.
struct Scenario {
  std::string name;
  std::string description;
  std::int64_t seed = 1;

  struct Run {
    double duration_s = 4.0;
    std::int64_t threads = 2;
  } run;

  /// Where the defaults of the world come from; none: they are those of the keys.
  std::optional<RandomWorldConfig> world;
  std::optional<Camera> drawn_camera;  ///< of a random world: what the keys of sim.camera start from

  SimConfig sim;
  std::string camera_preset = "icub_left_2016";          ///< the keys of sim.camera start from
  std::string right_camera_preset = "icub_right_2016";   ///< those of sim.right
  MountedCamera calibration{icub_left_2016, {}};         ///< the assumed left camera; by default the true one
  MountedCamera right_calibration{icub_right_2016, {}};  ///< the assumed right camera
  NamedDetectors detectors;
  /// A conventional camera and its detector, to compare with; scored under the name `frame_30hz`.
  std::optional<FrameDetectorConfig> frame_30hz;

  struct Gaze {
    std::string detector = "paper_directed";  ///< which of the detectors drives; none: the head stays still
    double acquire_within_deg = 2.0;          ///< for the score, GazeScoringConfig::acquire_within_rad
    GazeControllerConfig controller;
    FollowConfig follow;
    GateConfig gate;
    bool stereo = false;  ///< the ball's distance by triangulation, where both eyes see it
  } gaze;

  /// With kind `model` it has an entry for each detector, in their order, and one for the frame camera.
  LatencyConfig latency;

  struct Output {
    bool video = false;
    double video_speed = 1.0;                       ///< time of the run per time of the video
    std::string events = "aedat";                   ///< a format of `formats`, of FormatRegistry::run_choices
    FormatRegistry formats;                         ///< of the program
    std::int64_t pictures = 10;                     ///< how many instants the report shows in pictures
    std::optional<GroundTruthConfig> ground_truth;  ///< of every pixel
    bool eye_movements = false;                     ///< whether eye movements are scored, EyeMovementScore
  } output;

  std::vector<Expectation> expect;
};

/// A scenario without detectors that can name what the registry holds; everything else has its default.
[[nodiscard]] Scenario empty_scenario(const Registry& registry);

/// Keys: those of a scenario file.
void describe(FieldVisitor& v, Scenario& scenario);

/// Reads a scenario; one that saccade ships may be named as shipped_file() takes it. `assignments` are the `key.path=value` of --set, `seed` that of --seed. The values of
/// `calibration` start from the scenario's `camera`, or from the file that `calibration.file` names (as
/// read_calibration reads it; relative to the scenario, from --set relative to the working directory); those of
/// `right_calibration` likewise from `right_camera`.
/// With `world`, values of the world that the scenario does not give are those of draw_world(), detectors have
/// radius_range_px() as default of radius_px, and unless one of them drives the head, the head follows the world's script.
/// Throws InputError with everything that is wrong.
[[nodiscard]] Scenario read_scenario(const std::filesystem::path& path,
                                     const std::vector<std::string>& assignments,
                                     std::optional<std::int64_t> seed, const Registry& registry);
/// The same of a tree whose file lies in `folder`.
[[nodiscard]] Scenario read_scenario(YamlTree tree, const std::filesystem::path& folder,
                                     const Registry& registry);
/// The scenario that a file in `folder` names: relative to that folder; where there is no such file, one that saccade ships.
[[nodiscard]] std::filesystem::path scenario_file(const std::filesystem::path& folder,
                                                  const std::filesystem::path& name);
/// The scenario with every default, as YAML that reads back the same.
[[nodiscard]] std::string resolved_scenario(const Scenario& scenario);

/// Whether `path`, such as gaze.in_view_ratio, is a number in metrics.json of a run of this scenario.
[[nodiscard]] bool has_figure(const Scenario& scenario, const std::string& path);

/// The figures that are outside the bounds of `expect`, one line each; empty if none is.
[[nodiscard]] std::vector<std::string> unmet_expectations(const Scenario& scenario, const Metrics& metrics);

/// Reads a file of detectors (key `detectors`), or the registry's defaults where `path` is empty. An assignment whose
/// first word is the name of a detector holds for that one, any other for all that have the key.
/// Throws InputError with everything that is wrong, a key that none of them has included.
[[nodiscard]] NamedDetectors read_detectors(const std::filesystem::path& path,
                                            const std::vector<std::string>& assignments,
                                            const DetectorRegistry& registry);

/// The detectors of a run, and the file in its folder that has them.
struct RecordedDetectors {
  std::filesystem::path file;
  NamedDetectors detectors;
};
/// Reads the block `detectors` of detectors.yaml, scenario.yaml or robot.yaml in the folder of a run; other keys are not looked
/// at. Assignments as above. None where there is no such file or its block is empty. Throws InputError as above.
[[nodiscard]] std::optional<RecordedDetectors> read_recorded_detectors(
    const std::filesystem::path& folder, const std::vector<std::string>& assignments,
    const DetectorRegistry& registry);

/// Their keys, below "detectors.NAME.".
[[nodiscard]] KeyValues keys_of_detectors(NamedDetectors detectors);
/// The detectors with every default, as YAML that reads back the same.
[[nodiscard]] std::string resolved_detectors(NamedDetectors detectors);

/// Reads the assumed calibration of the left camera (0) or the right one (1): the block `calibration` of a file of `saccade
/// calibrate`, or a file of OpenCV, ROS or Kalibr (config/calibration_file.h); a key of the lens that is missing is an error.
/// Throws InputError with everything that is wrong.
[[nodiscard]] MountedCamera read_calibration(const std::filesystem::path& path, int camera = 0);

/// A calibration as such a file.
[[nodiscard]] std::string calibration_yaml(Calibration calibration);

/// Reads an event camera: the keys of a scenario's block `emulator`, at the file's top level or under the key
/// `emulator` as its only one; the defaults where `path` is empty. Assignments are `key=value` or
/// `emulator.key=value`. Throws InputError with everything that is wrong.
[[nodiscard]] EmulatorConfig read_emulator(const std::filesystem::path& path,
                                           const std::vector<std::string>& assignments);

}  // namespace saccade
