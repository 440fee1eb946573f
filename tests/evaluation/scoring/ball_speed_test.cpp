#include "evaluation/scoring/ball_speed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace saccade {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(BallSpeed, IsTheLengthOfTheVelocityAtEveryRow) {
  std::vector<TruthRow> truth;
  for (int i = 0; i < 100; ++i) {
    truth.push_back({.t_us = i * 1000, .circle = {0.3 * i, 100 - 0.4 * i, 10}, .visible = 1.0});
  }
  for (const double speed : image_speed_px_s(truth)) EXPECT_NEAR(speed, 500.0, 1e-9);
}

TEST(BallSpeed, OfACircularPathIsThatOfTheCircle) {
  std::vector<TruthRow> truth;
  const double turn_rad_s = 2.0 * std::numbers::pi * 2.5;
  for (int i = 0; i < 400; ++i) {
    const double angle = turn_rad_s * i * 1e-3;
    truth.push_back({.t_us = i * 1000, .circle = {64 + 40 * std::cos(angle), 64 + 40 * std::sin(angle), 10}});
  }
  // A chord of 10 ms is shorter than its arc by the square of the angle over 24: (0.157)^2 / 24 = 0.00103.
  for (const double speed : image_speed_px_s(truth))
    EXPECT_NEAR(speed, 40 * turn_rad_s, 1.1e-3 * 40 * turn_rad_s);
}

TEST(BallSpeed, IsNanWithoutACircleAndNeverComputedAcrossAGap) {
  std::vector<TruthRow> truth;
  for (int i = 0; i < 30; ++i) {
    const bool seen = i < 10 || i > 12;
    // The ball comes back far away from where it left.
    truth.push_back({.t_us = i * 1000, .circle = {seen ? 0.1 * i + (i > 12 ? 50 : 0) : nan, 64, 10}});
  }
  const std::vector<double> speed = image_speed_px_s(truth);
  for (int i = 0; i < 30; ++i) {
    if (i < 10 || i > 12) {
      EXPECT_NEAR(speed[static_cast<std::size_t>(i)], 100.0, 1e-9) << i;
    } else {
      EXPECT_TRUE(std::isnan(speed[static_cast<std::size_t>(i)])) << i;
    }
  }
}

TEST(BallSpeed, OfASingleRowIsNan) {
  const std::vector<TruthRow> truth = {{.t_us = 1000, .circle = {1, 2, 3}}};
  EXPECT_TRUE(std::isnan(image_speed_px_s(truth).at(0)));
}

TEST(SpeedCounts, PutEveryChanceIntoTheBinOfItsSpeedAndAddUpOverRuns) {
  const std::vector<std::optional<bool>> found = {true, false, std::nullopt, true, true, true};
  const std::vector<double> speed = {0.0, 9.9, 5.0, 10.0, nan, 1e6};
  SpeedCounts counts;
  for (int run = 0; run < 60; ++run) counts.add(found, speed);
  EXPECT_EQ(counts.chances.front(), 120);
  EXPECT_EQ(counts.found.front(), 60);
  EXPECT_EQ(counts.chances[1], 60);
  EXPECT_EQ(counts.chances.back(), 60);
  EXPECT_EQ(counts.rate_hz(0), 500.0);
  EXPECT_EQ(counts.rate_hz(1), 1000.0);
  EXPECT_EQ(counts.rate_hz(2), std::nullopt);
}

}  // namespace
}  // namespace saccade
