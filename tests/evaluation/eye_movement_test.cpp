#include "evaluation/eye_movement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

TEST(SaccadeFinder, TellsWhenHowFarAndHowFast) {
  const auto finder = watched(500, [](int t) { return shift_deg(t, 100, 80, 12.0); });
  ASSERT_EQ(finder.saccades().size(), 1U);
  const Saccade& saccade = finder.saccades().front();
  EXPECT_NEAR(saccade.peak_deg_s, 12.0 / 0.080 * 1.875, 0.5);
  // What is slower than 60 deg/s at either end lies outside: at the speed's profile 30 s^2 (1 - s)^2 that is from s =
  // 0.133 to 0.867, between 1.9 and 98.1 % of the way.
  EXPECT_NEAR(static_cast<double>(saccade.start_us), 110.7e3, 1.5e3);
  EXPECT_NEAR(static_cast<double>(saccade.end_us), 169.3e3, 1.5e3);
  EXPECT_NEAR(saccade.amplitude_deg, 11.54, 0.15);
  EXPECT_EQ(finder.speed_deg_s(), 0.0);
}

TEST(SaccadeFinder, KnowsPursuitAndJerksForNone) {
  EXPECT_TRUE(watched(500, [](int t) { return 0.055 * t; }).saccades().empty());               // 55 deg/s
  EXPECT_TRUE(watched(500, [](int t) { return 0.2 * std::min(t, 9); }).saccades().empty());    // 8 ms
  EXPECT_EQ(watched(500, [](int t) { return 0.2 * std::min(t, 11); }).saccades().size(), 1U);  // 10 ms
  EXPECT_EQ(watched(500, [](int t) { return 0.2 * (t - t % 10); }).saccades().size(), 0U);     // 1 ms each
}

TEST(SaccadeFinder, HasTheOneThatGoesOnAsLongAsItIsNow) {
  const auto finder = watched(31, [](int t) { return 0.1 * t; });
  ASSERT_EQ(finder.saccades().size(), 1U);
  EXPECT_EQ(finder.saccades().front().end_us, 31'000);
  EXPECT_NEAR(finder.saccades().front().amplitude_deg, 3.0, 1e-9);
  EXPECT_NEAR(finder.speed_deg_s(), 100.0, 1e-6);
}

}  // namespace
}  // namespace saccade
