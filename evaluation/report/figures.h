#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/report/palette.h"
#include "evaluation/scoring/ball_speed.h"
#include "evaluation/scoring/metrics.h"
#include "recording/run_files.h"

namespace saccade {

/// Figures of one run and of several, drawn by gnuplot. The same data give the same bytes. In the drawing every series
/// is thinned to at most max_figure_points. All times in the axes count from `start_us`. `name` becomes the figure's:
/// letters, digits, '-' and '_' only. All throw RunError when gnuplot is missing (naming the package) or fails.

inline constexpr std::size_t max_figure_points = 1200;

/// x, y and r over time: truth as a line, the detector's observations at or above its threshold as dots.
/// Annotated truth (`sparse`) is drawn as circles, not joined.
[[nodiscard]] Figure tracking_figure(std::string_view name, std::span<const TruthRow> truth,
                                     std::span<const DetectionRow> detections, std::string_view detector,
                                     double threshold, Colour colour, bool sparse, std::int64_t start_us);

/// Precision over recall of every detector; a square marks its threshold.
[[nodiscard]] Figure precision_recall_figure(std::string_view name, const Metrics& metrics);

/// Events of a run over time.
struct EventCounts {
  std::int64_t start_us = 0;
  std::int64_t bin_us = 10'000;
  std::vector<std::int64_t> counts;
};

/// The rate of events over time; below it, in 100 ms bins, the inliers per second of each detector; and the ball's speed
/// in the image (paper, Fig. 5). `found` from found_at_chances(), one per detector of `metrics`. Without dense truth
/// `truth` and `found` are empty: then all observations at or above the threshold are counted, and there is no speed.
/// `events` may be null. A detector named frame_30hz is the frame camera; without one, a line shows the highest rate
/// that a 30 Hz camera can reach.
[[nodiscard]] Figure rates_figure(std::string_view name, const EventCounts* events,
                                  std::span<const TruthRow> truth,
                                  std::span<const std::vector<std::optional<bool>>> found,
                                  std::span<const DetectionRow> detections, const Metrics& metrics,
                                  std::int64_t start_us);

/// A detector's name and colour in figures.
struct DrawnDetector {
  std::string name;
  Colour colour;
};

/// Detections per second over the ball's speed in the image, px/s.
struct DetectorSpeeds {
  DrawnDetector detector;
  SpeedCounts counts;
};
[[nodiscard]] Figure rate_over_speed_figure(std::string_view name, std::span<const DetectorSpeeds> detectors);

/// One detector in the runs of a group, one score or more.
struct DetectorRuns {
  DrawnDetector detector;
  std::vector<DetectorScore> scores;
};

/// Precision over recall: a thin line for every run, a thick one for the mean precision at each recall that all runs reach
/// (the curve itself where there is one run only); a square at the mean of precision and recall at the threshold.
[[nodiscard]] Figure precision_recall_spread_figure(std::string_view name,
                                                    std::span<const DetectorRuns> detectors);

/// Runs that differ in their seeds alone.
struct RunGroup {
  std::string label;
  std::vector<DetectorRuns> detectors;
};

/// Average precision of every detector, a panel for each group: a dot for every run, a bar of one standard
/// deviation to both sides of the mean.
[[nodiscard]] Figure average_precision_figure(std::string_view name, std::span<const RunGroup> groups);

}  // namespace saccade
