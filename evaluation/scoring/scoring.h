#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/detector.h"
#include "evaluation/scoring/clutter.h"
#include "evaluation/scoring/statistics.h"
#include "recording/run_files.h"

namespace saccade {

/// Scoring of ball detections against the true circle, after the paper's section III.

/// An observation is an inlier within these distances of the true circle (paper, Fig. 4).
inline constexpr double inlier_distance_px = 6.0;
inline constexpr double inlier_radius_px = 2.0;
/// A simulated instant is a chance from this visible share of the ball's disc on.
inline constexpr double chance_visible_share = 0.5;
/// The recalls at which precision is told.
inline constexpr std::array<double, 6> reported_recalls = {0.1, 0.2, 0.3, 0.5, 0.7, 0.9};
inline constexpr std::size_t max_curve_points = 200;

/// When the detector could have found the ball.
enum class Chances {
  /// Truth every 1 ms: each instant with visible >= 0.5. An observation at any other instant of the run is a
  /// false one.
  simulated,
  /// Truth at a few instants of a recording: exactly these. Observations at other instants are left out,
  /// nothing is known about them.
  annotated,
};

struct CurvePoint {
  double threshold = 0.0;
  double precision = 0.0;
  double recall = 0.0;
};

/// What metrics.json says of one detector. None = does not apply.
struct DetectorScore {
  /// Sum of precision times recall step over all distinct scores, no interpolation. None without chances.
  std::optional<double> average_precision;
  /// At the highest threshold whose recall reaches reported_recalls[i]; none when none does.
  std::array<std::optional<double>, reported_recalls.size()> precision_at_recall;
  /// By falling threshold; every distinct score, or 200 of them evenly spaced by rank with both ends kept.
  std::vector<CurvePoint> pr_curve;
  std::int64_t chances = 0;
  double threshold = 0.0;
  /// At `threshold`, like everything below.
  std::int64_t observations = 0;
  std::int64_t inliers = 0;
  std::optional<double> precision;  ///< none without observations
  std::optional<double> recall;     ///< none without chances
  /// Inliers per second over the 100 ms bins (from the first truth row on) that hold a chance, and in the
  /// best of those that lie wholly within the run. None for annotated chances.
  std::optional<double> mean_rate_hz;
  std::optional<double> peak_rate_hz;
  /// Over all observations at chances, inlier or not; no lag compensated.
  Spread position_error_px;
  Spread radius_error_px;  ///< absolute
  /// The shift s in [-50, 200] ms (0.1 ms steps) that minimises the median distance between the observation
  /// at t and truth, linearly interpolated, at t - s; positive = late; of equal shifts the one nearest 0.
  /// Over the observations at chances whose truth is known for every such s, that is without a gap of more
  /// than 20 ms between its rows. None when there is no such observation, or the true centres at the chances
  /// lie within 6 px (diagonal of their bounding box).
  std::optional<double> lag_ms;
  /// Processing time, flow included; measured by the loop, not here.
  std::optional<double> us_per_event;
  /// Events that the detector could not use; told by the detector, not here.
  std::optional<RejectedEvents> rejected_events;
  /// Where the events have labels; from detector_clutter.
  std::optional<DetectorClutter> clutter;
};

/// Scores one detector. `truth` and `detections` sorted by time; rows of other detectors are skipped. Throws
/// InputError when a detector has two rows for one instant, or a row is not finite.
[[nodiscard]] DetectorScore score_detector(std::span<const TruthRow> truth,
                                           std::span<const DetectionRow> detections,
                                           std::string_view detector, double threshold, Chances chances);

/// For every row of simulated truth whether the detector found the ball there, that is has an inlier at or
/// above `threshold`; none where there was no chance. Order and errors as in score_detector.
[[nodiscard]] std::vector<std::optional<bool>> found_at_chances(std::span<const TruthRow> truth,
                                                                std::span<const DetectionRow> detections,
                                                                std::string_view detector, double threshold);

/// How often per second the detector was right from `from_us` on: 1000 times the share of the chances; none without
/// any. `found` as found_at_chances tells it for `truth`.
[[nodiscard]] std::optional<double> found_rate_hz(std::span<const TruthRow> truth,
                                                  std::span<const std::optional<bool>> found,
                                                  std::int64_t from_us);

}  // namespace saccade
