#include "evaluation/scoring/gaze_scorer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.h"
#include "core/units.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

/// A left camera at the root's origin that looks along -x (ahead) turned to the right by an angle.
Eigen::Isometry3d looking(double right_deg) {
  Eigen::Matrix3d ahead;  // columns: the camera's x (right), y (down) and z (forward) axes in root
  ahead.col(0) = Eigen::Vector3d::UnitY();
  ahead.col(1) = -Eigen::Vector3d::UnitZ();
  ahead.col(2) = -Eigen::Vector3d::UnitX();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(-right_deg * rad_per_deg, Eigen::Vector3d::UnitZ()) * ahead;
  return pose;
}

Eigen::Vector3d ball_at(double right_deg, double distance_m = 0.45) {
  return distance_m *
         Eigen::Vector3d(-std::cos(right_deg * rad_per_deg), std::sin(right_deg * rad_per_deg), 0.0);
}

GazeScoringConfig wide_limits() {
  GazeScoringConfig config;
  config.camera = icub_left_2016;
  config.limits.min_rad.setConstant(-1.0);
  config.limits.max_rad.setConstant(1.0);
  return config;
}

/// A run of samples at 1 kHz from 1 ms on, with gaze and ball as angles to the right.
GazeScore run(int count, const std::function<double(int)>& gaze_deg,
              const std::function<double(int)>& ball_deg, GazeScoringConfig config = wide_limits()) {
  GazeScorer scorer(config);
  for (int t_ms = 1; t_ms <= count; ++t_ms) {
    GazeSample sample;
    sample.t_us = t_ms * 1000;
    sample.root_from_left_cam = looking(gaze_deg(t_ms));
    sample.ball_m = ball_at(ball_deg(t_ms));
    scorer.add(sample);
  }
  return scorer.score();
}

double still(int) { return 0.0; }

TEST(GazeScorer, MeasuresTheAngleBetweenTheOpticalAxisAndTheBall) {
  GazeScorer scorer(wide_limits());
  scorer.add({.t_us = 1000, .root_from_left_cam = looking(10.0), .ball_m = ball_at(25.0), .target_m = {}});
  EXPECT_NEAR(scorer.fixation_error_rad(), 15.0 * rad_per_deg, 1e-12);
}

TEST(GazeScorer, CountsAcquisitionFromTheFirstMotionOfTheBall) {
  // The ball rests on the axis, jumps 20 deg off at 300 ms, and the gaze is on it from 450 ms on, but for
  // 50 ms of an early visit that does not count.
  const auto ball = [](int t_ms) { return t_ms < 300 ? 0.0 : 20.0; };
  const auto gaze = [](int t_ms) { return (t_ms >= 340 && t_ms < 390) || t_ms >= 450 ? 19.0 : 0.0; };
  const GazeScore score = run(1000, gaze, ball);
  EXPECT_NEAR(*score.acquire_s, 0.150, 1e-9);
  EXPECT_EQ(score.acquired_at_us, 450'000);
  EXPECT_NEAR(*score.fixation_error_deg.median, 1.0, 1e-9);
  EXPECT_EQ(score.on_target_ratio, 1.0);
  EXPECT_EQ(score.in_view_ratio, 1.0);
}

TEST(GazeScorer, OfABallThatNeverMovesCountsFromTheFirstSample) {
  const GazeScore score = run(
      1000, [](int t_ms) { return t_ms <= 200 ? 10.0 : 0.0; }, still);
  EXPECT_NEAR(*score.acquire_s, 0.200, 1e-9);
}

TEST(GazeScorer, RatiosRunFromAcquisitionToTheEnd) {
  // 400 ms on the ball, 300 ms at 3 deg (in view, off target), 300 ms at 60 deg (out of view).
  const auto gaze = [](int t_ms) { return t_ms <= 400 ? 0.5 : t_ms <= 700 ? 3.0 : 60.0; };
  const GazeScore score = run(1000, gaze, still);
  EXPECT_NEAR(*score.acquire_s, 0.0, 1e-9);
  EXPECT_NEAR(*score.on_target_ratio, 0.4, 1e-9);
  EXPECT_NEAR(*score.in_view_ratio, 0.7, 1e-9);
  EXPECT_NEAR(*score.fixation_error_deg.median, 3.0, 1e-9);
  EXPECT_NEAR(*score.fixation_error_deg.p95, 60.0, 1e-9);
}

TEST(GazeScorer, WithoutATenthOfASecondOnTargetHasNoFixationFigures) {
  const GazeScore score = run(
      1000, [](int t_ms) { return t_ms % 90 < 80 ? 0.0 : 10.0; }, still);
  EXPECT_EQ(score.acquire_s, std::nullopt);
  EXPECT_EQ(score.fixation_error_deg.median, std::nullopt);
  EXPECT_EQ(score.on_target_ratio, std::nullopt);
  EXPECT_EQ(score.in_view_ratio, std::nullopt);
}

TEST(GazeScorer, PaperDetectorsAcquireWithinSixDegreesButAreOnTargetWithinTwo) {
  GazeScoringConfig config = wide_limits();
  config.acquire_within_rad = 6.0 * rad_per_deg;
  const GazeScore score = run(
      1000, [](int) { return 5.0; }, still, config);
  EXPECT_NEAR(score.acquire_within_deg, 6.0, 1e-12);
  EXPECT_EQ(score.acquire_s, 0.0);
  EXPECT_EQ(score.on_target_ratio, 0.0);
  EXPECT_EQ(run(
                1000, [](int) { return 5.0; }, still)
                .acquire_s,
            std::nullopt);
}

TEST(GazeScorer, CountsAMoveForEveryMillimetreOfTheTargetAndWrongOnesApart) {
  GazeScorer scorer(wide_limits());
  const Eigen::Vector3d ball = ball_at(0.0);
  std::int64_t t_us = 0;
  const auto hand_over = [&](std::optional<Eigen::Vector3d> target) {
    scorer.add(
        {.t_us = t_us += 1000, .root_from_left_cam = looking(0.0), .ball_m = ball, .target_m = target});
  };
  hand_over(std::nullopt);
  hand_over(ball);                                  // 1: on the ball
  hand_over(ball);                                  // held
  hand_over(ball + Eigen::Vector3d(0, 0.0006, 0));  // less than a millimetre
  hand_over(ball + Eigen::Vector3d(0, 0.0012, 0));  // 2: crept away, 0.27 px
  hand_over(ball + Eigen::Vector3d(0.1, 0.0, 0));   // 3: wrong depth, right direction
  hand_over(ball_at(3.0));                          // 4: 5.2 px
  hand_over(ball_at(4.0));                          // 5: 7.0 px, wrong
  hand_over(-ball);                                 // 6: behind, wrong
  const GazeScore score = scorer.score();
  EXPECT_EQ(score.moves, 6);
  EXPECT_EQ(score.wrong_moves, 2);
  // Errors 0, 0.0012, 0.1, 0.0236, 0.0314 and 0.9 m.
  EXPECT_NEAR(*score.target_error_median_m,
              0.45 * (std::sin(1.5 * rad_per_deg) + std::sin(2.0 * rad_per_deg)), 1e-9);
}

TEST(GazeScorer, WithoutATargetHasNoTargetError) {
  const GazeScore score = run(100, still, still);
  EXPECT_EQ(score.moves, 0);
  EXPECT_EQ(score.target_error_median_m, std::nullopt);
}

TEST(GazeScorer, ASaccadeIsTenMillisecondsAboveSixtyDegreesPerSecond) {
  const auto sweep = [](double speed_deg_s, int length_ms) {
    return run(
               200, [=](int t_ms) { return speed_deg_s * 1e-3 * std::clamp(t_ms - 50, 0, length_ms); }, still)
        .saccades;
  };
  EXPECT_EQ(sweep(59.0, 100), 0);
  EXPECT_EQ(sweep(61.0, 9), 0);
  EXPECT_EQ(sweep(61.0, 10), 1);
  EXPECT_EQ(sweep(300.0, 100), 1);
}

TEST(GazeScorer, TwoFastPhasesAreTwoSaccades) {
  const auto gaze = [](int t_ms) {
    return 0.2 * (std::clamp(t_ms - 20, 0, 20) - std::clamp(t_ms - 60, 0, 20));
  };
  EXPECT_EQ(run(200, gaze, still).saccades, 2);
}

TEST(GazeScorer, CountsSamplesWithAJointBeyondAHundredthOfADegree) {
  GazeScorer scorer(wide_limits());
  std::int64_t t_us = 0;
  for (const double excess_deg : {-1.0, 0.0, 0.009, 0.011, 5.0}) {
    for (const double sign : {-1.0, 1.0}) {
      GazeSample sample;
      sample.t_us = t_us += 1000;
      sample.root_from_left_cam = looking(0.0);
      sample.ball_m = ball_at(0.0);
      sample.plant_position_rad[eyes_tilt] = sign * (1.0 + excess_deg * rad_per_deg);
      scorer.add(sample);
    }
  }
  EXPECT_EQ(scorer.score().limit_violations, 4);
}

TEST(GazeScorer, RejectsAnAngleOfAcquisitionOutOfRange) {
  GazeScoringConfig config;
  config.camera = icub_left_2016;
  config.acquire_within_rad = 0.0;
  EXPECT_THROW(GazeScorer{config}, InputError);
}

}  // namespace
}  // namespace saccade
