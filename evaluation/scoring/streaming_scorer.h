#pragma once

#include <cstdint>
#include <optional>

#include "evaluation/scoring/observation.h"
#include "evaluation/scoring/precision_recall.h"
#include "evaluation/scoring/statistics.h"
#include "recording/run_files.h"

namespace saccade {

/// The figures of `streaming` in metrics.json: at every instant the newest estimate that was ready then.
struct StreamingScore {
  std::optional<double> average_precision;  ///< none without chances
  std::optional<double> precision;          ///< at the threshold; none without observations
  std::optional<double> recall;             ///< at the threshold; none without chances
  /// From the instant that an estimate is about to the time at which it was ready, over all observations, ms.
  std::optional<double> latency_median_ms;
  std::optional<double> latency_p99_ms;
  bool exact = true;  ///< false in runs so long that average precision and latency are approximated
};

/// Makes the streaming score of one detector in a simulated run instant by instant, in bounded memory (at most 24 bytes
/// per instant up to `max_exact` instants).
class StreamingScorer {
 public:
  explicit StreamingScorer(double threshold, std::size_t max_exact = max_exact_values)
      : threshold_(threshold), ranking_(max_exact), latency_ms_(max_exact) {}

  /// An instant, and the newest estimate that was ready then, if there is one; `latency_us`: from the instant that it
  /// is about to the time at which it was ready.
  void add(const TruthRow& truth, const std::optional<Observation>& newest, std::int64_t latency_us);
  [[nodiscard]] StreamingScore score() const;

 private:
  double threshold_;
  std::int64_t chances_ = 0;
  std::int64_t observations_ = 0;  // at or above the threshold
  std::int64_t inliers_ = 0;       // of them
  PrecisionRecallCounter ranking_;
  QuantileCounter latency_ms_;
};

}  // namespace saccade
