#include "session/recorded_scores.h"

#include <algorithm>
#include <limits>

namespace saccade {

RecordedScores::RecordedScores(const Loop& loop, const Observations& observations,
                               std::span<const TruthRow> truth, Chances chances,
                               const std::filesystem::path& table)
    : loop_(loop), observations_(observations), truth_(truth) {
  // The truth is in memory, so exact figures over all of it cost no other order of memory.
  const std::size_t max_exact = std::max(max_exact_values, 2 * truth.size());
  for (const LoopDetector& detector : loop.detectors())
    detectors_.push_back({DetectorScorer(detector.name, detector.detector->threshold(), chances, max_exact)});
  if (!table.empty()) table_.emplace(table);
}

void RecordedScores::pass_truth_before(std::int64_t t_us) {
  for (; next_truth_ < truth_.size() && truth_[next_truth_].t_us < t_us; ++next_truth_) {
    for (Detector& detector : detectors_) detector.scorer.add(truth_[next_truth_], std::nullopt);
  }
}

void RecordedScores::leave_out_truth_after(std::int64_t t_us) {
  const auto counts = [&](const TruthRow& row) { return row.t_us <= t_us; };
  truth_ =
      truth_.first(static_cast<std::size_t>(std::ranges::partition_point(truth_, counts) - truth_.begin()));
}

void RecordedScores::on_tick(const Tick& tick) {
  event_count_ += static_cast<std::int64_t>(tick.events.size());
  if (!tick.events.empty()) last_event_us_ = tick.events.back().t_us;
  for (std::size_t i = 0; i < detectors_.size(); ++i)
    detectors_[i].elapsed_ns += tick.detectors[i].elapsed_ns;
  if (!scoring_) return;
  pass_truth_before(tick.t_us);
  const bool has_truth = next_truth_ < truth_.size() && truth_[next_truth_].t_us == tick.t_us;
  if (table_) observations_.write_completed(*table_);
  const ObservedInstant& instant = observations_.completed().front();
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    Detector& detector = detectors_[i];
    detector.at_threshold += tick.detectors[i].at_threshold ? 1 : 0;
    std::optional<Observation> observation;
    if (const auto& seen = instant.observations[i]) observation = observation_of(*seen);
    if (has_truth) {
      detector.scorer.add(truth_[next_truth_], observation);
    } else {
      detector.scorer.add(tick.t_us, observation);
    }
  }
  next_truth_ += has_truth ? 1 : 0;
}

namespace {

/// No event of a recording comes late, and detection takes no time: every estimate is ready at its instant.
StreamingScore streaming_score(const DetectorScore& score) {
  StreamingScore streaming{score.average_precision, score.precision, score.recall, {}, {}, score.exact};
  if (score.observations > 0 || !score.pr_curve.empty())
    streaming.latency_median_ms = streaming.latency_p99_ms = 0.0;
  return streaming;
}

}  // namespace

std::vector<DetectorScore> RecordedScores::finish() {
  pass_truth_before(std::numeric_limits<std::int64_t>::max());
  if (table_) table_->commit();
  std::vector<DetectorScore> scores;
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    DetectorScore score = detectors_[i].scorer.score();
    if (truth_.empty()) score.observations = detectors_[i].at_threshold;
    score.streaming = streaming_score(score);
    if (event_count_ > 0) {
      score.us_per_event =
          static_cast<double>(detectors_[i].elapsed_ns) * 1e-3 / static_cast<double>(event_count_);
    }
    score.rejected_events = loop_.detectors()[i].detector->rejected();
    score.failure = loop_.detectors()[i].detector->failure();
    scores.push_back(std::move(score));
  }
  return scores;
}

}  // namespace saccade
