#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/detector.h"
#include "evaluation/scoring/clutter.h"
#include "evaluation/scoring/precision_recall.h"
#include "evaluation/scoring/statistics.h"
#include "evaluation/scoring/streaming_scorer.h"
#include "evaluation/scoring/uncertainty.h"
#include "recording/run_files.h"

namespace saccade {

/// Scores of ball detections against the true circle, after section III of Glover and Bartolozzi, "Event-driven ball
/// detection and gaze fixation in clutter" (IROS 2016), called the paper here. From vectors; DetectorScorer
/// (detector_scorer.h) makes the same score instant by instant.

/// An observation is an inlier within these distances of the true circle (paper, Fig. 4).
inline constexpr double inlier_distance_px = 6.0;
inline constexpr double inlier_radius_px = 2.0;
/// An instant is a chance when at least this share of the ball's disc is visible.
inline constexpr double chance_visible_share = 0.5;

/// At which instants a detector could find the ball. Observations at instants with 0 < visible < 0.5 are ignored: the
/// ball is partly hidden.
enum class Chances {
  /// Truth every 1 ms: each instant with visible >= 0.5. An observation at an instant with visible = 0, or without a row
  /// of truth, is false. No row of truth, or none with a circle: there is no ball, and every observation is false.
  simulated,
  /// Truth at a few instants of a recording: those with visible >= 0.5. An observation at an annotated instant with
  /// visible = 0 is false. Observations at instants without a row of truth are ignored.
  annotated,
};

/// A target that is no sphere has a visible centre and no radius: no figure of a detector applies, and all are none.

/// Whether a row of truth has a circle, finite in centre and radius.
[[nodiscard]] bool has_circle(const TruthRow& row);
/// Whether the ball could be found there: it has a circle, and visible >= 0.5.
[[nodiscard]] bool is_chance(const TruthRow& row);
/// Whether an observation at that row's instant counts, as an inlier or a false one; if not it is ignored.
[[nodiscard]] bool counts(const TruthRow& row, Chances chances);
/// How `truth` is to be scored: simulated where its rows are 1 ms apart without a gap, annotated otherwise.
[[nodiscard]] Chances chances_of(std::span<const TruthRow> truth);
[[nodiscard]] bool is_inlier(const Circle& circle, const Circle& truth);

/// The figures of one detector in metrics.json. None = does not apply.
struct DetectorScore {
  /// See CurveSummary. None, and an empty curve, without chances.
  std::optional<double> average_precision;
  std::array<std::optional<double>, reported_recalls.size()> precision_at_recall;
  std::vector<CurvePoint> pr_curve;  ///< by falling threshold
  std::int64_t chances = 0;
  /// NaN: unknown. Then every figure at the threshold is none, and `observations` and `inliers` are 0.
  double threshold = 0.0;
  /// At `threshold`, like everything below up to `nees`.
  std::int64_t observations = 0;
  std::int64_t inliers = 0;
  std::optional<double> precision;  ///< none without observations
  std::optional<double> recall;     ///< none without chances
  /// Inliers per second over the 100 ms bins (from the first truth row on) that hold a chance, and in the
  /// best of those that lie wholly within the run. None for annotated chances.
  std::optional<double> mean_rate_hz;
  std::optional<double> peak_rate_hz;
  /// Over all observations at chances, inlier or not; no lag compensated.
  Percentiles position_error_px;
  Percentiles radius_error_px;  ///< absolute
  /// See LagCounter; over the observations at chances. None also where the true centres at the chances lie within
  /// 6 px (diagonal of their bounding box), or move slower than 30 px/s in the median.
  std::optional<double> lag_ms;
  /// Where there is no ball at all: share of the instants with an observation.
  std::optional<double> alarm_ratio;
  /// There too: alarms per minute of instants; observations less than 100 ms apart are one alarm.
  std::optional<double> alarms_per_min;
  std::optional<Nees> nees;  ///< of the inliers; none without known covariances
  /// Of all observations that count, whatever the threshold; none where the score is no probability.
  std::optional<Reliability> reliability;
  std::optional<StreamingScore> streaming;  ///< none where it was not measured
  /// False where a run was so long that curve, errors or lag are approximated (DetectorScorer).
  bool exact = true;
  /// Processing time, flow included; measured by the loop.
  std::optional<double> us_per_event;
  /// Events that the detector could not use; counted by the detector.
  std::optional<RejectedEvents> rejected_events;
  /// Why the detector ended before the end of the run (Detector::failure()); empty: it did not.
  std::string failure;
  /// Where the events have labels; from detector_clutter().
  std::optional<DetectorClutter> clutter;
};

/// Scores one detector. `truth` and `detections` sorted by time; rows of other detectors are skipped. Throws
/// InputError when a detector has two rows for one instant, or a row is not finite.
[[nodiscard]] DetectorScore score_detector(std::span<const TruthRow> truth,
                                           std::span<const DetectionRow> detections,
                                           std::string_view detector, double threshold, Chances chances);

/// How many detections of a detector lie in the time of the truth, ends included, and how many of them at an instant of it.
struct SharedInstants {
  std::int64_t detections = 0;
  std::int64_t shared = 0;
};

/// Counts them. Order as in score_detector. Throws InputError with `place` where no figure can follow from the tables: the
/// detections end before the truth begins, begin after its end, or lie in its time and none at an instant of it. The
/// message names the instants of both.
SharedInstants check_instants(std::span<const TruthRow> truth, std::span<const DetectionRow> detections,
                              std::string_view detector, const std::string& place);

/// For every row of simulated truth whether the detector found the ball there, that is has an inlier at or
/// above `threshold`; none where there was no chance. Order and errors as in score_detector.
[[nodiscard]] std::vector<std::optional<bool>> found_at_chances(std::span<const TruthRow> truth,
                                                                std::span<const DetectionRow> detections,
                                                                std::string_view detector, double threshold);

/// How often per second a detector found the ball from `from_us` on: 1000 times the share of the chances; none without
/// any. `found` from found_at_chances() for `truth`.
[[nodiscard]] std::optional<double> found_rate_hz(std::span<const TruthRow> truth,
                                                  std::span<const std::optional<bool>> found,
                                                  std::int64_t from_us);

/// The rate of found_rate_hz() from the moment on at which the gaze acquired the ball, instant by instant.
class FollowingRate {
 public:
  /// `found` as DetectorScorer::add() returns it, `held_since_us` as GazeScorer::held_since_us() returns it after the
  /// same instant.
  void add(std::optional<bool> found, std::optional<std::int64_t> held_since_us);
  [[nodiscard]] std::optional<double> rate_hz() const;

 private:
  std::optional<std::int64_t> held_since_us_;
  std::int64_t chances_ = 0;
  std::int64_t found_ = 0;
};

}  // namespace saccade
