#include "evaluation/scoring/streaming_scorer.h"

#include "evaluation/scoring/scoring.h"

namespace saccade {

void StreamingScorer::add(const TruthRow& truth, const std::optional<Observation>& newest,
                          std::int64_t latency_us) {
  const bool chance = is_chance(truth);
  chances_ += chance ? 1 : 0;
  if (!newest || !counts(truth, Chances::simulated)) return;
  const bool inlier = chance && is_inlier(newest->circle, truth.circle);
  ranking_.add(newest->score, inlier);
  latency_ms_.add(static_cast<double>(latency_us) * 1e-3);
  if (!(newest->score >= threshold_)) return;
  ++observations_;
  inliers_ += inlier ? 1 : 0;
}

StreamingScore StreamingScorer::score() const {
  StreamingScore score;
  const auto inliers = static_cast<double>(inliers_);
  if (chances_ > 0) {
    score.average_precision = ranking_.summary(chances_).average_precision;
    score.recall = inliers / static_cast<double>(chances_);
  }
  if (observations_ > 0) score.precision = inliers / static_cast<double>(observations_);
  score.latency_median_ms = latency_ms_.at(0.5);
  score.latency_p99_ms = latency_ms_.at(0.99);
  score.exact = ranking_.exact() && latency_ms_.exact();
  return score;
}

}  // namespace saccade
