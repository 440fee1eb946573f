#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "evaluation/scoring/gaze_scorer.h"
#include "evaluation/scoring/scoring.h"
#include "head/head_state.h"

namespace saccade {

/// The gaze of a run and what drove it.
struct GazeMetrics {
  std::string detector;
  std::string controller;  ///< this and the next two empty where they are not known
  std::string gate;
  std::string window;  ///< of the detector's events, in words: "1500 events", "20 ms", "lifetime"
  GazeScore score;
  /// How often per second the detector was right from acquisition on, see found_rate_hz.
  std::optional<double> following_rate_hz;
  JointLimits limits;  ///< positions only, for the figures
};

/// What is known of the right eye of a run in which it sees, too.
struct RightEyeMetrics {
  std::int64_t event_count = 0;  ///< of the run's events, those of this eye
  std::optional<std::int64_t> events_dropped;
  Camera camera;
  MountedCamera calibration;  ///< what the loop believed of it
  /// Of this eye's axis, as GazeScore has them of the left one's; none without a gaze.
  Spread fixation_error_deg;
  std::optional<double> on_target_ratio;
  std::optional<double> in_view_ratio;
  std::vector<std::pair<std::string, DetectorScore>> detectors;  ///< those that looked through it
};

/// metrics.json, schema 1. None is written as null: the figure does not apply. Keys beyond the contract:
/// detectors.*.{observations,inliers,rejected_events}, gaze.{acquire_within_deg,joint_limits_rad,controller,gate,
/// window,acquired_at_us,following_rate_hz} and `events.file`, `events.camera`, `camera`, `calibration`, `start_us`, `settings`, which
/// make a run folder readable without its scenario; and, of
/// a run with labels alone, `clutter` and detectors.*.{clutter_in_window,clutter_per_detection}; and, of a run whose right
/// eye sees, `right_eye`. Everything else is of the left eye, but for `events`, which counts those of both.
struct Metrics {
  std::string scenario;
  std::optional<std::int64_t> seed;
  /// What was set otherwise than the scenario has it, key and value as given; without output.* and run.*,
  /// which change nothing that is scored. Runs of one scenario with the same settings differ in their seed.
  std::vector<std::pair<std::string, std::string>> settings;
  std::int64_t start_us = 0;     ///< what the events' clock showed when the run began
  double duration_s = 0.0;       ///< of the run, in its own time
  std::optional<double> wall_s;  ///< of the loop alone; real_time_factor is duration_s / wall_s
  std::int64_t event_count = 0;  ///< passed to the detectors; the rate is per second of duration_s
  std::optional<std::int64_t> events_dropped;
  /// The events' file: relative to the run folder, or absolute when the recording lies elsewhere.
  std::string events_file;
  std::optional<std::uint8_t> events_camera;  ///< whose events in it the detectors got; none: the left one's
  ImageSize image;
  std::optional<Camera> camera;                                  ///< where it is known
  std::optional<MountedCamera> calibration;                      ///< what the loop believed of it
  std::vector<std::pair<std::string, DetectorScore>> detectors;  ///< in the order of the scenario
  std::optional<GazeMetrics> gaze;
  std::optional<ClutterShare> clutter;       ///< where the events have labels
  std::optional<RightEyeMetrics> right_eye;  ///< where it sees
};

/// Numbers are the shortest text that reads back as the same double; the same metrics give the same bytes.
[[nodiscard]] std::string metrics_to_json(const Metrics& metrics);
/// Throws InputError with `place` for text that is no JSON, another schema, or a key missing or of a wrong
/// kind. `calibration`, `settings`, `rejected_events`, what is told of clutter and the right eye and the last five of those of the gaze
/// may be absent.
[[nodiscard]] Metrics metrics_from_json(std::string_view text, const std::string& place);

/// Throws RunError when the disk does not take it.
void write_metrics(const std::filesystem::path& path, const Metrics& metrics);
/// Throws InputError.
[[nodiscard]] Metrics read_metrics(const std::filesystem::path& path);

}  // namespace saccade
