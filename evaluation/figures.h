#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "evaluation/metrics.h"
#include "recording/run_files.h"

namespace saccade {

/// Figures of a run as stand-alone SVG texts, drawn by gnuplot. The same data give the same bytes: no date,
/// no name of a machine. Every series is thinned to at most max_figure_points. All times in the axes count
/// from `start_us`. `name` must be unique within a page: it prefixes the ids inside the SVG. All throw
/// RunError when gnuplot is missing (naming the package) or fails.

inline constexpr std::size_t max_figure_points = 1200;

/// The colour of the detector at `index` in metrics.json, "#rrggbb"; the same in every figure and picture.
[[nodiscard]] std::string detector_colour(std::size_t index);

/// x, y and r over time: truth as a line, the detector's observations at or above its threshold as dots.
/// Annotated truth (`sparse`) is drawn as circles, not joined.
[[nodiscard]] std::string tracking_figure(std::string_view name, std::span<const TruthRow> truth,
                                          std::span<const DetectionRow> detections, std::string_view detector,
                                          double threshold, std::string_view colour, bool sparse,
                                          std::int64_t start_us);

/// Precision over recall of every detector; a square where its threshold lies.
[[nodiscard]] std::string precision_recall_figure(std::string_view name, const Metrics& metrics);

/// Ball, gaze targets and fixation point in the root frame, m.
[[nodiscard]] std::string gaze_path_figure(std::string_view name, std::span<const TruthRow> truth,
                                           std::span<const GazeRow> gaze);

/// The angle between the ray to the true circle's centre and the optical axis over time, deg.
[[nodiscard]] std::string fixation_figure(std::string_view name, std::span<const TruthRow> truth,
                                          const PinholeCamera& camera, std::int64_t start_us);

/// Each head joint over time against its limits, deg.
[[nodiscard]] std::string joints_figure(std::string_view name, std::span<const GazeRow> gaze,
                                        const JointLimits& limits, std::int64_t start_us);

/// Event rate over time, and below it the rate of accepted observations of every detector in 100 ms bins.
struct EventCounts {
  std::int64_t start_us = 0;
  std::int64_t bin_us = 10'000;
  std::vector<std::int64_t> counts;
};
[[nodiscard]] std::string rates_figure(std::string_view name, const EventCounts& events,
                                       std::span<const DetectionRow> detections, const Metrics& metrics,
                                       std::int64_t start_us);

}  // namespace saccade
