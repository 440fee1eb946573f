#include "evaluation/scoring/eye_movement_score.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/units.h"
#include "evaluation/scoring/metrics.h"

namespace saccade {
namespace {

constexpr double tau = 2.0 * std::numbers::pi;

using Angle = std::function<double(double)>;  // deg to the right, by time, s

Eigen::Vector3d axis_of(double right_deg) {
  return {-std::cos(right_deg * rad_per_deg), std::sin(right_deg * rad_per_deg), 0.0};
}

/// An eye at the origin: where it looks, where the ball is, and where a head that does not move has the ball.
EyeMovementScore watched(
    const EyeMovementProtocol& protocol, double duration_s, const Angle& gaze, const Angle& ball,
    const Angle& still = [](double) { return 0.0; }) {
  EyeMovementScorer scorer(protocol);
  for (int t_ms = 1; t_ms <= duration_s * 1e3; ++t_ms) {
    const double t_s = t_ms * 1e-3;
    EyeMovementSample sample;
    sample.t_us = t_ms * 1000;
    sample.gaze_deg = {gaze(t_s), 0.0};
    sample.ball_deg = {ball(t_s), 0.0};
    sample.seen_deg = {ball(t_s) - gaze(t_s), 0.0};
    sample.still_deg = {still(t_s), 0.0};
    sample.image_px = {64.0 + 2.0 * (ball(t_s) - gaze(t_s)), 64.0};
    scorer.add(sample, axis_of(gaze(t_s)));
  }
  return scorer.score();
}

TEST(EyeMovementScore, PursuitThatIsHalfAsLargeAndFiftyMillisecondsLateHasThatGainAndPhase) {
  const auto score = watched(
      {.pursuit_hz = 1.0, .sway_hz = {}}, 6.3,
      [](double t) { return 3.0 + 4.0 * std::sin(tau * (t - 0.05)); },
      [](double t) { return 8.0 * std::sin(tau * t); });
  ASSERT_TRUE(score.pursuit);
  EXPECT_NEAR(score.pursuit->gain, 0.5, 1e-3);
  EXPECT_NEAR(score.pursuit->phase_deg, -18.0, 0.05);
  EXPECT_NEAR(*score.pursuit_lag_ms, 50.0, 0.2);
  EXPECT_FALSE(score.stabilisation);
  EXPECT_FALSE(score.ramps);
}

TEST(EyeMovementScore, AnEyeThatCancelsThreeQuartersOfASwayReducesTheSlipByThem) {
  const Angle still = [](double t) { return 5.0 * std::sin(tau * 0.5 * t); };
  const auto score = watched(
      {.pursuit_hz = {}, .sway_hz = 0.5}, 9.0, [&](double t) { return -0.25 * still(t); },
      [](double) { return 0.0; }, still);
  ASSERT_TRUE(score.stabilisation);
  EXPECT_NEAR(score.stabilisation->gain, 0.75, 1e-3);
  EXPECT_NEAR(score.stabilisation->phase_deg, 0.0, 0.05);
  EXPECT_NEAR(*score.slip_reduction, 0.75, 1e-3);
  // 2 px per deg: peak 2 * 1.25 * pi px/s, of whose sine the median is sin 45 deg.
  EXPECT_NEAR(*score.image_median_px_s, 2.5 * std::numbers::pi * std::sqrt(0.5), 0.1);
}

TEST(EyeMovementScore, AStepHasItsSizeLatencyPeakSpeedAndTimeToArrive) {
  const Angle ball = [](double t) { return t < 2.0 ? 0.0 : 10.0; };
  // From 0.1 s after the jump on at 100 deg/s.
  const Angle gaze = [](double t) { return std::clamp(100.0 * (t - 2.1), 0.0, 10.0); };
  const auto score = watched({}, 4.0, gaze, ball);
  ASSERT_EQ(score.steps.size(), 1U);
  EXPECT_NEAR(score.steps[0].size_deg, 10.0, 1e-9);
  EXPECT_NEAR(*score.steps[0].latency_ms, 100.0, 6.0);
  EXPECT_NEAR(score.steps[0].peak_deg_s, 100.0, 1e-6);
  EXPECT_NEAR(*score.steps[0].settled_ms, 190.0, 4.0);
  EXPECT_EQ(score.saccades, 1);
}

TEST(EyeMovementScore, AGazeThatNeverMovesHasNoLatency) {
  const auto score = watched(
      {}, 4.0, [](double) { return 0.0; }, [](double t) { return t < 2.0 ? 0.0 : 10.0; });
  ASSERT_EQ(score.steps.size(), 1U);
  EXPECT_FALSE(score.steps[0].latency_ms);
  EXPECT_FALSE(score.steps[0].settled_ms);
}

TEST(EyeMovementScore, ARampThatIsFollowedTwoDegreesBehindHasThatLagAndAGainOfOne) {
  // To and fro at 20 deg/s between 0 and 10 deg.
  const Angle ball = [](double t) { return 10.0 - std::abs(std::fmod(20.0 * t, 20.0) - 10.0); };
  const auto score = watched(
      {}, 6.0, [&](double t) { return ball(t - 0.1); }, ball);
  ASSERT_TRUE(score.ramps);
  EXPECT_GE(score.ramps->count, 8);
  EXPECT_NEAR(score.ramps->ball_deg_s, 20.0, 0.1);
  EXPECT_NEAR(score.ramps->gain, 1.0, 0.02);
  EXPECT_NEAR(score.ramps->lag_deg, 2.0, 0.05);
  EXPECT_TRUE(score.steps.empty());
}

TEST(EyeMovementScore, TheMainSequenceIsTheLineThroughSizesAndPeakSpeeds) {
  // Saccades of 4, 8 and 12 deg at constant speeds of 100, 160 and 220 deg/s: 15 per second times size + 40 deg/s.
  const Angle gaze = [](double t) {
    return std::clamp(100.0 * (t - 1.0), 0.0, 4.0) + std::clamp(160.0 * (t - 2.0), 0.0, 8.0) +
           std::clamp(220.0 * (t - 3.0), 0.0, 12.0);
  };
  const auto score = watched({}, 4.0, gaze, [](double) { return 0.0; });
  EXPECT_EQ(score.saccades, 3);
  EXPECT_NEAR(*score.main_sequence_per_s, 15.0, 0.5);
  EXPECT_NEAR(*score.main_sequence_offset_deg_s, 40.0, 4.0);
}

TEST(EyeMovementScore, DirectionsAreToTheRightAndUp) {
  EXPECT_NEAR(direction_deg({-1.0, 1.0, 0.0}).x(), 45.0, 1e-9);
  EXPECT_NEAR(direction_deg({-1.0, 0.0, 1.0}).y(), 45.0, 1e-9);
  EXPECT_NEAR(direction_in_camera_deg({1.0, 0.0, 1.0}).x(), 45.0, 1e-9);
  EXPECT_NEAR(direction_in_camera_deg({0.0, -1.0, 1.0}).y(), 45.0, 1e-9);
}

TEST(EyeMovementScore, MetricsOfEyeMovementsReadBackAsWritten) {
  Metrics metrics;
  metrics.scenario = "s";
  metrics.image = {128, 128};
  metrics.gaze.emplace();
  metrics.gaze->detector = "best";
  EXPECT_EQ(metrics_to_json(metrics).find("eye_movements"), std::string::npos);
  metrics.gaze->eye_movements = watched(
      {.pursuit_hz = 1.0, .sway_hz = 1.0}, 5.0, [](double t) { return std::sin(tau * t); },
      [](double t) { return 2.0 * std::sin(tau * t); }, [](double t) { return std::cos(tau * t); });
  metrics.gaze->eye_movements->steps = {{5.0, 80.0, 200.0, std::nullopt}};
  metrics.gaze->eye_movements->ramps = GazeRamps{3, 20.0, 0.9, 1.0};
  const std::string text = metrics_to_json(metrics);
  EXPECT_NE(text.find("eye_movements"), std::string::npos);
  EXPECT_EQ(metrics_to_json(metrics_from_json(text, "here")), text);
}

TEST(SlipHistogram, SharesAddUpToOneAndFastMotionIsInTheLastBin) {
  const SlipHistogram histogram = slip_histogram({5.0, 15.0, 15.0, 1e6});
  EXPECT_DOUBLE_EQ(histogram.shares[0], 0.25);
  EXPECT_DOUBLE_EQ(histogram.shares[1], 0.5);
  EXPECT_DOUBLE_EQ(histogram.shares.back(), 0.25);
}

}  // namespace
}  // namespace saccade
