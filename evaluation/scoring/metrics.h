#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "evaluation/scoring/eye_movement_score.h"
#include "evaluation/scoring/gaze_scorer.h"
#include "evaluation/scoring/scoring.h"
#include "head/head_state.h"
#include "recording/file_digest.h"

namespace saccade {

/// The gaze of a run and the detector and controller behind it.
struct GazeMetrics {
  std::string detector;
  std::string controller;  ///< this and the next two are empty where they were not recorded
  std::string gate;
  std::string window;  ///< of the detector's events, in words: "1500 events", "20 ms", "lifetime"
  GazeScore score;
  /// How often per second the detector found the ball from acquisition on, see found_rate_hz().
  std::optional<double> following_rate_hz;
  JointLimits limits;  ///< positions only, for the figures
  /// Why the gaze controller ended before the end of the run (GazeController::failure()); empty: it did not.
  std::string failure = {};
  std::optional<EyeMovementScore> eye_movements = {};  ///< where the scenario asks for them
};

/// The right eye of a run with two cameras.
struct RightEyeMetrics {
  std::int64_t event_count = 0;  ///< of the run's events, those of this eye
  std::optional<std::int64_t> events_dropped;
  Camera camera;
  MountedCamera calibration;  ///< the assumed calibration
  /// Of this eye's axis, as GazeScore has them of the left one's; none without a gaze.
  Percentiles fixation_error_deg;
  std::optional<double> on_target_ratio;
  std::optional<double> in_view_ratio;
  std::vector<std::pair<std::string, DetectorScore>> detectors;  ///< those that used its events
};

/// A run in which parts of the loop take time.
struct LatencyMetrics {
  struct Detector {
    std::string name;
    std::optional<double> busy_ratio;  ///< processing time over the run's time
    std::int64_t events_left_out = 0;  ///< dropped because too many waited
  };

  std::string kind;  ///< "model" or "measured"
  std::vector<Detector> detectors;
};

/// The contents of metrics.json, schema 1. None is written as null: the figure does not apply. Everything is of the left
/// eye but `events`, which counts those of both, and `right_eye`. docs/run_folder.md describes the keys.
struct Metrics {
  std::string scenario;
  std::optional<std::int64_t> seed;
  /// Overrides of the scenario (`--set`), key and value as given; without output.* and run.*, which change nothing
  /// that is scored.
  std::vector<std::pair<std::string, std::string>> settings;
  std::int64_t start_us = 0;     ///< time of the events' clock at the start of the run
  double duration_s = 0.0;       ///< of the run, in its own time
  std::optional<double> wall_s;  ///< of the loop alone; real_time_factor is duration_s / wall_s
  bool interrupted = false;      ///< ended before its time: everything is of what was processed until then
  std::int64_t event_count = 0;  ///< passed to the detectors; the rate is per second of duration_s
  std::optional<std::int64_t> events_dropped;
  /// The event file: relative to the run folder, or absolute when the recording lies elsewhere.
  std::string events_file;
  std::optional<std::uint8_t>
      events_camera;  ///< the camera whose events the detectors got; none: the left one
  ImageSize image;
  std::optional<Camera> camera;                                  ///< where it is known
  std::optional<MountedCamera> calibration;                      ///< the assumed calibration
  std::vector<std::pair<std::string, DetectorScore>> detectors;  ///< in the order of the scenario
  std::optional<GazeMetrics> gaze;
  /// Without `gaze`, which a deployed run does not have: GazeMetrics::failure.
  std::string controller_failure;
  std::optional<ClutterShare> clutter;       ///< where the events have labels
  std::optional<RightEyeMetrics> right_eye;  ///< of a run with two cameras
  std::optional<LatencyMetrics> latency;     ///< where the scenario has a latency
  /// What the run read beside its configuration, with contents; `mentioned` is not written.
  std::vector<FileDigest> files;
};

/// The share of the left camera's events that its bus dropped; none where it is not known or no event arose.
[[nodiscard]] std::optional<double> dropped_share(const Metrics& metrics);
/// The same for the right camera.
[[nodiscard]] std::optional<double> dropped_share(const RightEyeMetrics& eye);
/// One sentence if a camera of the run dropped more than 1 % of its events; empty otherwise.
[[nodiscard]] std::string dropped_warning(const Metrics& metrics);
/// dropped_warning() for one camera, of which `whose` is the name ("the event camera").
[[nodiscard]] std::string dropped_warning(const std::string& whose, std::int64_t events,
                                          std::int64_t dropped);

/// Numbers are the shortest text that reads back as the same double; the same metrics give the same bytes.
[[nodiscard]] std::string metrics_to_json(const Metrics& metrics);
/// The same without what the wall clock measured (wall_s, real_time_factor, us_per_event) and without the folder of the
/// files: equal runs give equal bytes.
[[nodiscard]] std::string figures_to_json(const Metrics& metrics);
/// The block `detectors` of metrics.json alone, with the schema.
[[nodiscard]] std::string detectors_to_json(const std::vector<std::pair<std::string, DetectorScore>>& scores);
/// Throws InputError with `place` for text that is not JSON, another schema, or a key that is missing or of a wrong
/// type. Keys that older versions did not write may be absent: `interrupted`, `files`, `calibration`, `settings`, `approximate`, `right_eye`,
/// `controller_failure`, `clutter`, `latency`, `events.camera`; `rejected_events`, `failure`, `alarm_ratio`,
/// `alarms_per_min`, `streaming`, `nees`, `reliability` and clutter of a detector; `controller`, `gate`, `window`,
/// `acquired_at_us`, `following_rate_hz` and `eye_movements` of the gaze; `k1` to `p2` of a camera.
[[nodiscard]] Metrics metrics_from_json(std::string_view text, const std::string& place);

/// Throws RunError when the file cannot be written.
void write_metrics(const std::filesystem::path& path, const Metrics& metrics);
/// Writes figures_to_json(). Throws as write_metrics().
void write_figures(const std::filesystem::path& path, const Metrics& metrics);
/// Throws InputError.
[[nodiscard]] Metrics read_metrics(const std::filesystem::path& path);

}  // namespace saccade
