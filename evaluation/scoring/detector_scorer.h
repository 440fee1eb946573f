#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "core/camera.h"
#include "evaluation/scoring/lag.h"
#include "evaluation/scoring/observation.h"
#include "evaluation/scoring/precision_recall.h"
#include "evaluation/scoring/scoring.h"
#include "evaluation/scoring/statistics.h"
#include "evaluation/scoring/uncertainty.h"
#include "recording/run_files.h"

namespace saccade {

/// Scores one detector while a run goes on, in bounded memory.
///
/// The figures are those of score_detector() over the same instants, exact up to `max_exact` observations and instants
/// of truth (DetectorScore::exact). Beyond that counts, precision, recall and rates stay exact, and the rest is
/// approximated as PrecisionRecallCounter, QuantileCounter and LagCounter describe. Memory: up to 88 bytes per instant,
/// 23 MB at most for the default `max_exact`.
class DetectorScorer {
 public:
  /// `detector` is its name in error messages. `threshold` NaN: unknown.
  DetectorScorer(std::string detector, double threshold, Chances chances,
                 std::size_t max_exact = max_exact_values);

  /// An instant with a row of truth, and the detector's observation there, if it has one. Time does not go back.
  /// Returns whether the detector found the ball there, that is whether the observation is an inlier at or above the
  /// threshold; none where the instant is no chance. Throws InputError for an observation that is not finite or not
  /// later than the one before.
  std::optional<bool> add(const TruthRow& truth, const std::optional<Observation>& observation);
  /// An instant without a row of truth. Throws as above.
  void add(std::int64_t t_us, const std::optional<Observation>& observation);

  /// Whether that is an observation with a score at or above the threshold.
  [[nodiscard]] bool accepts(const std::optional<Observation>& observation) const {
    return observation && observation->score >= threshold_;
  }
  /// Of everything added so far. Streaming, processing time, rejected events and clutter are left empty.
  [[nodiscard]] DetectorScore score() const;

 private:
  /// Inliers per second in 100 ms bins that begin with the first row of truth.
  class Rate {
   public:
    void add(std::int64_t t_us, bool chance, bool found);
    void write(DetectorScore& score) const;

   private:
    void close_bin();

    bool started_ = false;
    std::int64_t begin_us_ = 0;
    std::int64_t last_us_ = 0;
    std::int64_t bin_ = 0;  // the one at hand
    std::int64_t bin_chances_ = 0;
    std::int64_t bin_inliers_ = 0;
    std::int64_t time_us_ = 0;  // of the bins before that hold a chance
    std::optional<double> peak_hz_;
  };

  void check(std::int64_t t_us, const Observation& observation);
  void count(const Observation& observation, const Circle* inlier_of);
  void count_instant(std::int64_t t_us, const std::optional<Observation>& observation);
  void follow(const TruthRow& truth);
  [[nodiscard]] bool moves() const;

  std::string detector_;
  double threshold_;
  Chances kind_;
  std::int64_t last_observation_us_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t chances_ = 0;
  std::int64_t observations_ = 0;  // at or above the threshold
  std::int64_t inliers_ = 0;       // of them
  PrecisionRecallCounter ranking_;
  QuantileCounter distance_px_;
  QuantileCounter radius_error_px_;
  LagCounter lag_;
  Rate rate_;
  ReliabilityCounter reliability_;
  NeesCounter nees_;
  bool ball_ = false;          // a row of truth has had a circle
  bool no_circle_ = false;     // a row of truth has had a centre without radius: a target that is no sphere
  std::int64_t instants_ = 0;  // and alarms: where there is no ball
  std::int64_t alarm_instants_ = 0;
  std::int64_t alarms_ = 0;
  std::optional<std::int64_t> last_alarm_us_;
  Circle lowest_, highest_;  // bounding box of the true centres at chances
  std::optional<TruthRow> last_chance_;
  QuantileCounter speed_px_s_;  // of the true centre from chance to chance
};

}  // namespace saccade
