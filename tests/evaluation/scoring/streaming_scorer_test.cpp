#include "evaluation/scoring/streaming_scorer.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/random.h"
#include "evaluation/scoring/detector_scorer.h"

namespace saccade {
namespace {

TruthRow truth_at(std::int64_t t_ms, double x_px, double visible = 1.0) {
  return {.t_us = t_ms * 1000, .circle = {x_px, 50, 20}, .visible = visible};
}

TEST(StreamingScorer, ScoresTheNewestEstimateAgainstTheTruthOfNow) {
  // An estimate every 4 ms, right when it is made; the ball moves by 2 px per ms.
  StreamingScorer scorer(0.5);
  Observation newest;
  for (std::int64_t t_ms = 1; t_ms <= 40; ++t_ms) {
    const double x_px = 2.0 * static_cast<double>(t_ms);
    if (t_ms % 4 == 1) newest = {{x_px, 50, 20}, 0.9};
    scorer.add(truth_at(t_ms, x_px), newest, 0);
  }
  const StreamingScore moving = scorer.score();
  EXPECT_EQ(moving.recall, 1.0) << "up to 3 ms, 6 px, behind";
  StreamingScorer fast(0.5);
  for (std::int64_t t_ms = 1; t_ms <= 40; ++t_ms) {
    const double x_px = 3.0 * static_cast<double>(t_ms);
    if (t_ms % 4 == 1) newest = {{x_px, 50, 20}, 0.9};
    fast.add(truth_at(t_ms, x_px), newest, 0);
  }
  EXPECT_EQ(fast.score().recall, 0.75) << "9 px behind after 3 ms";
  EXPECT_EQ(fast.score().precision, 0.75);
}

TEST(StreamingScorer, IsTheEventTimeScoreWhereEveryEstimateIsReadyAtItsInstant) {
  const RandomStream random(3, "streaming scorer");
  StreamingScorer streaming(0.5);
  DetectorScorer by_event_time("d", 0.5, Chances::simulated);
  for (std::uint64_t i = 1; i <= 3000; ++i) {
    const TruthRow truth =
        truth_at(static_cast<std::int64_t>(i), 60.0, i % 7 == 0 ? random.uniform(0, i) : 1.0);
    std::optional<Observation> observation;
    if (random.uniform(1, i) < 0.8)
      observation = Observation{{60.0 + 4.0 * random.normal(2, i), 50, 20}, random.uniform(3, i)};
    streaming.add(truth, observation, 0);
    by_event_time.add(truth, observation);
  }
  const DetectorScore expected = by_event_time.score();
  const StreamingScore score = streaming.score();
  EXPECT_EQ(score.average_precision, expected.average_precision);
  EXPECT_EQ(score.precision, expected.precision);
  EXPECT_EQ(score.recall, expected.recall);
  EXPECT_EQ(score.latency_median_ms, 0.0);
}

TEST(StreamingScorer, HasTheMedianAndTheLongestLatencies) {
  StreamingScorer scorer(0.5);
  for (std::int64_t t_ms = 1; t_ms <= 101; ++t_ms)
    scorer.add(truth_at(t_ms, 50), Observation{{50, 50, 20}, 1}, t_ms * 100);
  EXPECT_DOUBLE_EQ(*scorer.score().latency_median_ms, 5.1);
  EXPECT_DOUBLE_EQ(*scorer.score().latency_p99_ms, 10.0);
}

TEST(StreamingScorer, WithoutChancesOrObservationsHasNoFigures) {
  StreamingScorer scorer(0.5);
  scorer.add(truth_at(1, 50, 0.0), std::nullopt, 0);
  const StreamingScore score = scorer.score();
  EXPECT_EQ(score.average_precision, std::nullopt);
  EXPECT_EQ(score.precision, std::nullopt);
  EXPECT_EQ(score.recall, std::nullopt);
  EXPECT_EQ(score.latency_median_ms, std::nullopt);
}

}  // namespace
}  // namespace saccade
