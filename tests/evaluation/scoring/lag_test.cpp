#include "evaluation/scoring/lag.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/scoring/precision_recall.h"

namespace saccade {
namespace {

/// A ball on a circle in the image.
Circle circle_at(double t_us) {
  return {64.0 + 30.0 * std::cos(6e-6 * t_us), 64.0 + 30.0 * std::sin(6e-6 * t_us), 12.0};
}

/// `seconds` with observations `late_ms` behind the truth.
LagCounter counted(double late_ms, double seconds, std::size_t max_exact = max_exact_values) {
  LagCounter lag(max_exact);
  for (std::int64_t t_us = 0; t_us < static_cast<std::int64_t>(1e6 * seconds); t_us += 1000) {
    const auto t = static_cast<double>(t_us);
    lag.add(t_us, circle_at(t), circle_at(t - 1e3 * late_ms));
  }
  return lag;
}

TEST(LagCounter, IsTheShiftWithTheLeastMedianDistance) {
  for (const double late_ms : {-30.0, 0.0, 7.3, 150.0}) {
    const LagCounter lag = counted(late_ms, 2.0);
    ASSERT_TRUE(lag.lag_ms());
    EXPECT_NEAR(*lag.lag_ms(), late_ms, 0.11) << "steps of 0.1 ms";
    EXPECT_TRUE(lag.exact());
  }
}

TEST(LagCounter, StaysNearItWithFewerInstants) {
  const LagCounter lag = counted(12.0, 60.0, 20'000);
  EXPECT_FALSE(lag.exact());
  ASSERT_TRUE(lag.lag_ms());
  EXPECT_NEAR(*lag.lag_ms(), 12.0, 0.11);
}

TEST(LagCounter, IsNoneWhereTruthHasGapsOrNothingIsObserved) {
  LagCounter gaps, silent;
  for (std::int64_t t_us = 0; t_us < 2'000'000; t_us += 1000) {
    const auto t = static_cast<double>(t_us);
    const bool known = t_us % 100'000 < 70'000;  // gaps of 30 ms
    gaps.add(t_us, known ? std::optional(circle_at(t)) : std::nullopt, circle_at(t));
    silent.add(t_us, circle_at(t), std::nullopt);
  }
  EXPECT_FALSE(gaps.lag_ms());
  EXPECT_FALSE(silent.lag_ms());
}

TEST(PrecisionRecallCounter, HasOnePointForEachScore) {
  PrecisionRecallCounter counter;
  for (const auto& [score, inlier] : {std::pair{0.9, true}, {0.5, false}, {0.5, true}, {0.1, true}})
    counter.add(score, inlier);
  const CurveSummary summary = counter.summary(4);
  ASSERT_EQ(summary.points.size(), 3U);
  EXPECT_TRUE(counter.exact());
  // Precision times step of recall: 1 x 1/4 + 2/3 x 1/4 + 3/4 x 1/4.
  EXPECT_DOUBLE_EQ(summary.average_precision, 0.25 * (1.0 + 2.0 / 3.0 + 0.75));
  EXPECT_EQ(summary.precision_at_recall[0], 1.0) << "recall 0.1";
  EXPECT_DOUBLE_EQ(*summary.precision_at_recall[3], 2.0 / 3.0) << "recall 0.5";
  EXPECT_FALSE(summary.precision_at_recall[5]) << "recall 0.9 is not reached";
}

TEST(PrecisionRecallCounter, BinsOfALongRunGiveNearlyTheSameCurve) {
  PrecisionRecallCounter exact(100'000), binned(100);
  for (int i = 0; i < 20'000; ++i) {
    const double score = 1e-3 + std::fmod(0.618 * i, 1.0);
    const bool inlier = std::fmod(0.31 * i, 1.0) < score;
    exact.add(score, inlier);
    binned.add(score, inlier);
  }
  EXPECT_TRUE(exact.exact());
  EXPECT_FALSE(binned.exact());
  EXPECT_NEAR(binned.summary(20'000).average_precision, exact.summary(20'000).average_precision, 2e-3);
  EXPECT_LE(binned.summary(20'000).points.size(), max_curve_points);
}

}  // namespace
}  // namespace saccade
