#include "evaluation/scoring/eye_movement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace saccade {
namespace {

/// An eye that looks `right_deg(t_ms)` to the right, at 1 kHz from 1 ms on.
template <class Angle>
SaccadeFinder watched(int count, Angle right_deg) {
  SaccadeFinder finder;
  for (int t_ms = 1; t_ms <= count; ++t_ms) {
    const double angle = right_deg(t_ms) * std::numbers::pi / 180.0;
    finder.add(t_ms * 1000, {-std::cos(angle), std::sin(angle), 0.0});
  }
  return finder;
}

/// Minimum jerk from 0 to `size_deg` within `duration_ms` after `start_ms`: its peak is 15/8 of its mean.
double shift_deg(double t_ms, double start_ms, double duration_ms, double size_deg) {
  const double s = std::clamp((t_ms - start_ms) / duration_ms, 0.0, 1.0);
  return size_deg * s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

TEST(SaccadeFinder, MeasuresTimeAmplitudeAndPeakSpeed) {
  const auto finder = watched(500, [](int t) { return shift_deg(t, 100, 80, 12.0); });
  ASSERT_EQ(finder.count(), 1);
  const Saccade& saccade = finder.newest();
  EXPECT_NEAR(saccade.peak_deg_s, 12.0 / 0.080 * 1.875, 0.5);
  // What is slower than 60 deg/s at either end lies outside: at the speed's profile 30 s^2 (1 - s)^2 that is from s =
  // 0.133 to 0.867, between 1.9 and 98.1 % of the way.
  EXPECT_NEAR(static_cast<double>(saccade.start_us), 110.7e3, 1.5e3);
  EXPECT_NEAR(static_cast<double>(saccade.end_us), 169.3e3, 1.5e3);
  EXPECT_NEAR(saccade.amplitude_deg, 11.54, 0.15);
  EXPECT_EQ(finder.speed_deg_s(), 0.0);
}

TEST(SaccadeFinder, FindsNoneInPursuitAndSingleSteps) {
  EXPECT_EQ(watched(500, [](int t) { return 0.055 * t; }).count(), 0);              // 55 deg/s
  EXPECT_EQ(watched(500, [](int t) { return 0.2 * std::min(t, 9); }).count(), 0);   // 8 ms
  EXPECT_EQ(watched(500, [](int t) { return 0.2 * std::min(t, 11); }).count(), 1);  // 10 ms
  EXPECT_EQ(watched(500, [](int t) { return 0.2 * (t - t % 10); }).count(), 0);     // 1 ms each
}

TEST(SaccadeFinder, ReturnsAnUnfinishedSaccadeAsLongAsItIsNow) {
  const auto finder = watched(31, [](int t) { return 0.1 * t; });
  ASSERT_EQ(finder.count(), 1);
  EXPECT_EQ(finder.newest().end_us, 31'000);
  EXPECT_NEAR(finder.newest().amplitude_deg, 3.0, 1e-9);
  EXPECT_NEAR(finder.speed_deg_s(), 100.0, 1e-6);
}

TEST(Moves, AreTargetsMoreThanAMillimetreApart) {
  std::vector<GazeRow> gaze(6);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double y_m[] = {nan, 0.1, 0.1, 0.1006, 0.1012, 0.1012};  // from the last move on, not from row to row
  for (std::size_t i = 0; i < gaze.size(); ++i) {
    gaze[i].t_us = 1000 * static_cast<std::int64_t>(i);
    gaze[i].target_m = {-0.5, y_m[i], 0.3};
  }
  const std::vector<Move> moves = moves_of(gaze);
  ASSERT_EQ(moves.size(), 2U);
  EXPECT_EQ(moves[0].t_us, 1000);
  EXPECT_EQ(moves[1].t_us, 4000);
  EXPECT_EQ(moves[1].target_m.y(), 0.1012);
}

/// A point half a metre ahead of an eye at the root's origin, so many degrees to the right.
Eigen::Vector3d ahead(double right_deg) {
  const double angle = right_deg * std::numbers::pi / 180.0;
  return 0.5 * Eigen::Vector3d(-std::cos(angle), std::sin(angle), 0.0);
}

TEST(GazeShifts, AreTheLargestFromTheTargetToTheEyesArrival) {
  // Targets at 1, 1.1, 3, 5 and 7 s; the eye goes a hundredth of what is left every millisecond.
  const auto target_deg = [](int t_ms) {
    return t_ms < 1100 ? 10.0 : t_ms < 3000 ? 9.0 : t_ms < 5000 ? 9.5 : t_ms < 7000 ? 4.5 : 8.0;
  };
  std::vector<GazeRow> gaze;
  std::vector<EyeRow> eye;
  double right_deg = 0.0;
  for (int t_ms = 1; t_ms <= 8000; ++t_ms) {
    if (t_ms > 1000) right_deg += 0.01 * (target_deg(t_ms) - right_deg);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const Eigen::Vector3d axis = ahead(right_deg).normalized();
    pose.linear().col(0) = axis.cross(Eigen::Vector3d::UnitZ());
    pose.linear().col(1) = -Eigen::Vector3d::UnitZ();
    pose.linear().col(2) = axis;
    eye.push_back(EyeRow::of(t_ms * 1000, pose));
    GazeRow row;
    row.t_us = t_ms * 1000;
    row.target_m = ahead(target_deg(t_ms));
    if (t_ms < 1000) row.target_m.setConstant(std::numeric_limits<double>::quiet_NaN());
    gaze.push_back(row);
  }
  const auto shifts = largest_gaze_shifts(gaze, eye, 4);
  // That at 1.1 s is too near to the first, that at 3 s too small.
  ASSERT_EQ(shifts.size(), 3U);
  EXPECT_EQ(shifts[0].start_us, 1'000'000);
  EXPECT_EQ(shifts[1].start_us, 5'000'000);
  EXPECT_EQ(shifts[2].start_us, 7'000'000);
  // A quarter is left after 138 steps; of the first a little less, its newest target being nearer.
  EXPECT_NEAR(static_cast<double>(shifts[1].end_us - shifts[1].start_us), 138e3, 1.5e3);
  EXPECT_LT(shifts[0].end_us, 1'138'000);
  EXPECT_GT(shifts[0].end_us, 1'100'000);
  const auto largest = largest_gaze_shifts(gaze, eye, 1);
  ASSERT_EQ(largest.size(), 1U);
  EXPECT_EQ(largest[0].start_us, 1'000'000);
  EXPECT_TRUE(largest_gaze_shifts(gaze, {}, 4).empty());
}

}  // namespace
}  // namespace saccade
