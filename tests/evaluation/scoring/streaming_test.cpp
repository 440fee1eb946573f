#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "evaluation/scoring/detector_scorer.h"
#include "evaluation/scoring/gaze_scorer.h"

namespace saccade {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Instants {
  std::vector<TruthRow> truth;
  std::vector<DetectionRow> detections;
};

/// A ball that circles, partly hidden at times, and a detector that is 12 ms late with noise and some clutter.
Instants circling(int count) {
  const RandomStream random(11, "streaming test");
  const auto centre = [](double t_s) {
    const double phase = 2.0 * std::numbers::pi * 2.5 * t_s;
    return Eigen::Vector2d(64.0 + 30.0 * std::cos(phase), 64.0 + 20.0 * std::sin(phase));
  };
  Instants instants;
  for (int i = 1; i <= count; ++i) {
    const auto k = static_cast<std::uint64_t>(i);
    const std::int64_t t_us = i * 1000;
    const Eigen::Vector2d p = centre(i * 1e-3);
    const double visible = i % 900 > 800 ? 0.3 : 1.0;
    instants.truth.push_back({.t_us = t_us, .circle = {p.x(), p.y(), 20.0}, .visible = visible});
    if (random.uniform(1, k) < 0.3) continue;
    const bool wrong = random.uniform(2, k) < 0.2;
    const Eigen::Vector2d q = centre(i * 1e-3 - 0.012) + Eigen::Vector2d(wrong ? 40.0 : 0.0, 0.0);
    instants.detections.push_back(
        {t_us,
         "d",
         {q.x() + random.normal(3, k), q.y() + random.normal(4, k), 20.0 + 0.7 * random.normal(5, k)},
         std::abs((wrong ? 0.4 : 0.7) + 0.2 * random.normal(6, k)),
         false});
  }
  return instants;
}

DetectorScore streamed(const Instants& instants, std::size_t max_exact) {
  DetectorScorer scorer("d", 0.5, Chances::simulated, max_exact);
  auto row = instants.detections.begin();
  for (const TruthRow& truth : instants.truth) {
    std::optional<Observation> observation;
    if (row != instants.detections.end() && row->t_us == truth.t_us) {
      observation = {row->circle, row->score};
      ++row;
    }
    scorer.add(truth, observation);
  }
  return scorer.score();
}

TEST(DetectorScorer, GivesTheFiguresOfTheVectorsUpToItsBound) {
  const Instants instants = circling(5000);
  const DetectorScore whole =
      score_detector(instants.truth, instants.detections, "d", 0.5, Chances::simulated);
  const DetectorScore streaming = streamed(instants, 5000);
  EXPECT_TRUE(streaming.exact);
  EXPECT_EQ(streaming.average_precision, whole.average_precision);
  EXPECT_EQ(streaming.precision_at_recall, whole.precision_at_recall);
  EXPECT_EQ(streaming.pr_curve.size(), whole.pr_curve.size());
  EXPECT_EQ(streaming.observations, whole.observations);
  EXPECT_EQ(streaming.mean_rate_hz, whole.mean_rate_hz);
  EXPECT_EQ(streaming.peak_rate_hz, whole.peak_rate_hz);
  EXPECT_EQ(streaming.position_error_px.p95, whole.position_error_px.p95);
  EXPECT_EQ(streaming.lag_ms, whole.lag_ms);
}

TEST(DetectorScorer, BeyondItsBoundCountsStayExactAndTheRestIsCloseAndMarkedAsApproximate) {
  const Instants instants = circling(40'000);
  const DetectorScore whole =
      score_detector(instants.truth, instants.detections, "d", 0.5, Chances::simulated);
  const DetectorScore streaming = streamed(instants, 8192);
  EXPECT_TRUE(whole.exact);
  EXPECT_FALSE(streaming.exact);
  EXPECT_EQ(streaming.chances, whole.chances);
  EXPECT_EQ(streaming.observations, whole.observations);
  EXPECT_EQ(streaming.inliers, whole.inliers);
  EXPECT_EQ(streaming.precision, whole.precision);
  EXPECT_EQ(streaming.recall, whole.recall);
  EXPECT_EQ(streaming.mean_rate_hz, whole.mean_rate_hz);
  EXPECT_EQ(streaming.peak_rate_hz, whole.peak_rate_hz);
  EXPECT_NEAR(*streaming.average_precision, *whole.average_precision, 1e-3);
  // Half a bin of fine_bin() at most.
  for (const auto& [a, b] : {std::pair(*streaming.position_error_px.median, *whole.position_error_px.median),
                             std::pair(*streaming.position_error_px.p95, *whole.position_error_px.p95),
                             std::pair(*streaming.radius_error_px.median, *whole.radius_error_px.median)}) {
    EXPECT_NEAR(a, b, 0.0006 * b);
  }
  EXPECT_NEAR(*streaming.lag_ms, *whole.lag_ms, 0.2);
  EXPECT_NEAR(*whole.lag_ms, 12.0, 0.2);
}

TEST(DetectorScorer, TheSameInstantsGiveTheSameFiguresBeyondTheBoundToo) {
  const Instants instants = circling(20'000);
  const DetectorScore a = streamed(instants, 4096);
  const DetectorScore b = streamed(instants, 4096);
  EXPECT_EQ(a.average_precision, b.average_precision);
  EXPECT_EQ(a.position_error_px.median, b.position_error_px.median);
  EXPECT_EQ(a.lag_ms, b.lag_ms);
}

/// Bytes in use on the heap; 0 where a sanitizer replaces the allocator.
std::size_t heap_bytes() {
  const auto heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

TEST(DetectorScorer, NeedsNoMoreMemoryInALongerRun) {
  const RandomStream random(12, "memory test");
  DetectorScorer scorer("d", 0.5, Chances::simulated, 4096);
  GazeScoringConfig config;
  config.camera = {.size = {128, 128}, .fx_px = 100, .fy_px = 100, .cx_px = 63.5, .cy_px = 63.5};
  config.limits.min_rad.setConstant(-1.0);
  config.limits.max_rad.setConstant(1.0);
  GazeScorer gaze(config, 4096);
  std::size_t early_bytes = 0;
  for (std::uint64_t i = 1; i <= 600'000; ++i) {
    const auto t_us = static_cast<std::int64_t>(i) * 1000;
    const double x_px = 64.0 + 30.0 * std::sin(1e-3 * static_cast<double>(i));
    const TruthRow truth{.t_us = t_us, .circle = {x_px, 64.0, 20.0}, .visible = 1.0};
    scorer.add(truth, Observation{{x_px + random.normal(0, i), 64.0, 20.0}, 0.5 + random.uniform(1, i)});
    GazeSample sample;
    sample.t_us = t_us;
    sample.ball_m = {0.001 * random.uniform(2, i), 0.0, 0.4};
    sample.target_m = Eigen::Vector3d(0.01 * random.uniform(3, i), 0.0, 0.4);
    gaze.add(sample);
    if (i == 100'000) early_bytes = heap_bytes();
  }
  // Bins of rare values are added, and the lag has one block or two; 500,000 instants would be 36 MB.
  EXPECT_LT(heap_bytes(), early_bytes + 1'500'000);
}

TEST(DetectorScorer, ReturnsAtEachChanceWhetherTheBallWasFound) {
  DetectorScorer scorer("d", 0.5, Chances::simulated);
  const TruthRow here{.t_us = 1000, .circle = {50, 50, 20}, .visible = 1.0};
  EXPECT_EQ(scorer.add(here, Observation{{51, 50, 20}, 0.9}), true);
  TruthRow next = here;
  next.t_us = 2000;
  EXPECT_EQ(scorer.add(next, Observation{{51, 50, 20}, 0.4}), false);  // below the threshold
  next.t_us = 3000;
  EXPECT_EQ(scorer.add(next, std::nullopt), false);
  next.t_us = 4000;
  next.visible = 0.4;
  EXPECT_EQ(scorer.add(next, Observation{{51, 50, 20}, 0.9}), std::nullopt);
}

TEST(DetectorScorer, RejectsObservationsThatAreNotFiniteOrNotLaterThanTheOneBefore) {
  DetectorScorer scorer("d", 0.5, Chances::simulated);
  EXPECT_THROW(scorer.add(1000, Observation{{nan, 50, 20}, 0.9}), InputError);
  scorer.add(2000, Observation{{50, 50, 20}, 0.9});
  EXPECT_THROW(scorer.add(2000, Observation{{50, 50, 20}, 0.9}), InputError);
}

TEST(Scoring, RowsOfARecordingWithLessThanHalfOfTheBallVisibleAreNoChances) {
  std::vector<TruthRow> truth;
  std::vector<DetectionRow> detections;
  for (int i = 1; i <= 4; ++i) {
    truth.push_back({.t_us = i * 10'000, .circle = {50, 50, 20}, .visible = 1.0});
    detections.push_back({i * 10'000, "d", {50, 50, 20}, 0.9, false});
  }
  truth[1].visible = 0.49;
  truth[2].visible = 0.5;
  truth[3].visible = 0.0;
  const DetectorScore score = score_detector(truth, detections, "d", 0.5, Chances::annotated);
  EXPECT_EQ(score.chances, 2);
  EXPECT_EQ(score.inliers, 2);
  // Nothing is counted where the ball is partly hidden; where it is not visible the observation is false.
  EXPECT_EQ(score.observations, 3);
  EXPECT_EQ(score.recall, 1.0);
}

TEST(QuantileCounter, IsExactUpToItsBoundAndWithinOneBinBeyondIt) {
  const RandomStream random(5, "quantile counter test");
  std::vector<double> values;
  QuantileCounter exact(1000);
  QuantileCounter binned(999);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    values.push_back(random.normal(0, i) * 10.0);  // both signs
    exact.add(values.back());
    binned.add(values.back());
  }
  EXPECT_TRUE(exact.exact());
  EXPECT_FALSE(binned.exact());
  for (const double share : {0.0, 0.1, 0.5, 0.95, 1.0}) {
    const double value = *quantile(values, share);
    EXPECT_EQ(exact.at(share), value);
    EXPECT_NEAR(*binned.at(share), value, 0.0006 * std::abs(value) + 1e-12);
  }
  binned.clear();
  EXPECT_EQ(binned.at(0.5), std::nullopt);
}

TEST(FineBin, KeepsTheOrderOfNumbersAndHasNumbersOfItsOwnInItsMiddle) {
  double last = -std::numeric_limits<double>::infinity();
  for (const double value : {-1e300, -2.0, -1.0, -1e-9, 0.0, 1e-12, 0.5, 0.501, 7.0, 1e300}) {
    EXPECT_LT(last, value);
    if (std::isfinite(last)) {
      EXPECT_LT(fine_bin(last), fine_bin(value));
    }
    EXPECT_EQ(fine_bin(middle_of_bin(fine_bin(value))), fine_bin(value));
    last = value;
  }
}

TEST(FollowingRate, CountsTheChancesSinceTheGazeHeldTheBall) {
  FollowingRate rate;
  rate.add(true, std::nullopt);  // the gaze is elsewhere
  rate.add(true, 2000);
  rate.add(false, std::nullopt);  // lost: begins anew
  rate.add(true, 4000);
  rate.add(false, 4000);
  rate.add(std::nullopt, 4000);  // no chance
  rate.add(true, 4000);
  rate.add(false, 4000);
  EXPECT_EQ(rate.rate_hz(), 500.0);
}

TEST(GazeScorer, BeyondItsBoundCountsStayExactAndPercentilesAreClose) {
  GazeScoringConfig config;
  config.camera = {.size = {128, 128}, .fx_px = 100, .fy_px = 100, .cx_px = 63.5, .cy_px = 63.5};
  config.limits.min_rad.setConstant(-1.0);
  config.limits.max_rad.setConstant(1.0);
  const RandomStream random(6, "gaze streaming test");
  GazeScorer exact(config);
  GazeScorer bounded(config, 500);
  for (std::uint64_t i = 0; i < 3000; ++i) {
    GazeSample sample;
    sample.t_us = static_cast<std::int64_t>(i) * 1000;
    const double off_rad = 0.01 * random.uniform(0, i);
    sample.ball_m = {std::sin(off_rad), 0.0, std::cos(off_rad)};
    sample.target_m = sample.ball_m;
    exact.add(sample);
    bounded.add(sample);
  }
  const GazeScore a = exact.score();
  const GazeScore b = bounded.score();
  EXPECT_TRUE(a.exact);
  EXPECT_FALSE(b.exact);
  EXPECT_EQ(a.moves, b.moves);
  EXPECT_EQ(a.on_target_ratio, b.on_target_ratio);
  EXPECT_NEAR(*b.fixation_error_deg.median, *a.fixation_error_deg.median,
              0.0006 * *a.fixation_error_deg.median);
}

}  // namespace
}  // namespace saccade
