#include "control/target_predictor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "core/random.h"

namespace saccade {
namespace {

using Path = std::function<Eigen::Vector3d(double)>;
constexpr double tick_s = 1e-3;
constexpr double memory_s = 0.045;

/// On a circle of 7 cm, upright.
Path circle(double frequency_hz) {
  return [frequency_hz](double t_s) {
    const double angle = 2.0 * std::numbers::pi * frequency_hz * t_s;
    return Eigen::Vector3d(-0.5, 0.07 * std::cos(angle), 0.35 + 0.07 * std::sin(angle));
  };
}

/// Passes the path with 2 mm of noise (depth: 10 mm) up to end_s to the predictor, each point age_s late.
void watch(TargetPredictor& predictor, const Path& path, double begin_s, double end_s, double age_s = 0.0) {
  const RandomStream random(1, "test/predictor");
  const auto ticks = static_cast<std::uint64_t>(std::lround(end_s / tick_s));
  for (auto i = static_cast<std::uint64_t>(std::lround(begin_s / tick_s)); i < ticks; ++i) {
    predictor.advance(tick_s);
    const Eigen::Vector3d noise(0.01 * random.normal(0, i), 0.002 * random.normal(1, i),
                                0.002 * random.normal(2, i));
    const double t_s = static_cast<double>(i + 1) * tick_s - age_s;
    if (t_s > 0.0) predictor.observe(path(t_s) + noise, age_s);
  }
}

double sideways_error_m(const TargetPredictor& predictor, const Path& path, double now_s, double lead_s) {
  return (predictor.predict(lead_s).position_m - path(now_s + lead_s)).tail<2>().norm();
}

TEST(TargetPredictor, FindsTheFrequencyOfACircleWithinAPeriodAndAHalf) {
  for (const double frequency_hz : {0.5, 0.83, 1.0, 1.61, 2.0, 2.5}) {
    TargetPredictor predictor(memory_s, true);
    watch(predictor, circle(frequency_hz), 0.0, std::max(1.5 / frequency_hz, 0.8));
    ASSERT_TRUE(predictor.sinusoid().has_value()) << frequency_hz;
    EXPECT_NEAR(predictor.sinusoid()->frequency_hz, frequency_hz, 0.03 * frequency_hz);
  }
}

TEST(TargetPredictor, PredictsACircleOfTwoHertzATenthOfASecondAhead) {
  TargetPredictor predictor(memory_s, true);
  watch(predictor, circle(2.0), 0.0, 3.0);
  // In that time the ball moves by 88 mm.
  EXPECT_LT(sideways_error_m(predictor, circle(2.0), 3.0, 0.1), 0.004);
}

TEST(TargetPredictor, PredictsFromObservationsThatAreOld) {
  TargetPredictor predictor(memory_s, true);
  watch(predictor, circle(1.0), 0.0, 4.0, 0.08);
  EXPECT_LT(sideways_error_m(predictor, circle(1.0), 4.0, 0.02), 0.004);

  TargetPredictor straight(memory_s, true);
  const Path line = [](double t_s) { return Eigen::Vector3d(-0.5, 0.2 * t_s, 0.3); };
  watch(straight, line, 0.0, 1.5, 0.08);
  EXPECT_FALSE(straight.sinusoid().has_value());
  EXPECT_LT(sideways_error_m(straight, line, 1.5, 0.02), 0.005);
}

TEST(TargetPredictor, EqualsTheTrackWithoutModels) {
  TargetPredictor predictor(memory_s, false);
  TargetTrack track(memory_s);
  const Path path = circle(1.0);
  for (int i = 0; i < 3000; ++i) {
    predictor.advance(tick_s);
    track.advance(tick_s);
    if (i % 3 == 0) {
      predictor.observe(path(i * tick_s), 0.0);
      track.observe(path(i * tick_s));
    }
    if (i == 0) continue;
    ASSERT_EQ(predictor.predict(0.0).position_m, track.position_m());
    ASSERT_EQ(predictor.predict(0.0).velocity_m_s, track.velocity_m_s());
  }
}

TEST(TargetPredictor, DropsTheSinusoidWhenTheTargetStops) {
  TargetPredictor predictor(memory_s, true);
  const Path path = [](double t_s) { return circle(2.0)(std::min(t_s, 2.1)); };
  watch(predictor, path, 0.0, 2.0);
  ASSERT_TRUE(predictor.sinusoid().has_value());
  watch(predictor, path, 2.0, 2.3);
  EXPECT_FALSE(predictor.sinusoid().has_value());
  watch(predictor, path, 2.3, 2.7);
  EXPECT_LT(sideways_error_m(predictor, path, 2.7, 0.02), 0.004);
}

TEST(TargetPredictor, FollowsASinusoidThroughAGapAndForgetsItAfterASecond) {
  TargetPredictor predictor(memory_s, true);
  watch(predictor, circle(1.0), 0.0, 3.0);
  for (int i = 0; i < 300; ++i) predictor.advance(tick_s);
  EXPECT_LT(sideways_error_m(predictor, circle(1.0), 3.3, 0.0), 0.008);
  for (int i = 0; i < 800; ++i) predictor.advance(tick_s);
  EXPECT_FALSE(predictor.sinusoid().has_value());
  for (int i = 0; i < 300; ++i) predictor.advance(tick_s);
  EXPECT_LT(predictor.predict(0.0).velocity_m_s.norm(), 0.01);
}

/// Upright in front of the head at a constant speed, to the left.
Path straight(double speed_m_s) {
  return [speed_m_s](double t_s) { return Eigen::Vector3d(-0.5, 0.1 - speed_m_s * t_s, 0.35); };
}

/// The last 60 ms before 1.5 s drag the target along with what begins to cover it, then there is none until end_s.
void cover(TargetPredictor& predictor, const Path& path, double end_s) {
  watch(predictor, path, 0.0, 1.44);
  for (int i = 0; i < 60; ++i) {
    predictor.advance(tick_s);
    predictor.observe(path(1.44) + Eigen::Vector3d(-0.03, 0.0004 * i, 0.0), 0.0);
  }
  for (int i = 0; i < std::lround((end_s - 1.5) / tick_s); ++i) predictor.advance(tick_s);
}

TEST(TargetPredictor, FollowsAStraightPathForASecondWhileTheTargetIsCovered) {
  for (const double speed_m_s : {0.0, 0.08, 0.15}) {
    TargetPredictor predictor(memory_s, true);
    cover(predictor, straight(speed_m_s), 2.3);
    EXPECT_LT(sideways_error_m(predictor, straight(speed_m_s), 2.3, 0.0), 0.015) << speed_m_s;
    EXPECT_NEAR(predictor.predict(0.0).velocity_m_s.y(), -speed_m_s, 0.015) << speed_m_s;
    for (int i = 0; i < 700; ++i) predictor.advance(tick_s);
    EXPECT_LT((predictor.predict(0.0).position_m - straight(speed_m_s)(2.5)).tail<2>().norm(), 0.02);
    EXPECT_EQ(predictor.predict(0.0).velocity_m_s.norm(), 0.0);
  }
}

TEST(TargetPredictor, FollowsTheTargetAgainWhenItAppears) {
  TargetPredictor predictor(memory_s, true);
  cover(predictor, straight(0.08), 1.9);
  const Path elsewhere = [](double t_s) { return straight(-0.05)(t_s); };
  watch(predictor, elsewhere, 1.9, 2.3);
  EXPECT_LT(sideways_error_m(predictor, elsewhere, 2.3, 0.02), 0.005);
}

TEST(TargetPredictor, ComesToRestWithoutTargetsWhereThePathWasFastOrBent) {
  for (const Path& path : {straight(0.4), circle(0.6)}) {
    TargetPredictor predictor(memory_s, true);
    watch(predictor, path, 0.0, 0.7);
    for (int i = 0; i < 400; ++i) predictor.advance(tick_s);
    EXPECT_LT(predictor.predict(0.0).velocity_m_s.norm(), 0.01);
  }
}

TEST(TargetPredictor, FindsNoSinusoidInWaypointsNorAtRest) {
  // Back and forth at 0.2 m/s with rests, as in gaze_square, and a ball at rest.
  const Path corners = [](double t_s) {
    const double lap_s = std::fmod(t_s, 8.0);
    const auto ease = [](double u) { return u * u * u * (10.0 + u * (6.0 * u - 15.0)); };
    const double leg_s = std::fmod(lap_s, 2.0);
    const double there = ease(std::min(leg_s / 1.5, 1.0));
    const int leg = static_cast<int>(lap_s / 2.0);
    const double y = leg == 0 ? there : leg == 1 ? 1.0 : leg == 2 ? 1.0 - there : 0.0;
    const double z = leg == 1 ? there : leg == 2 ? 1.0 : leg == 3 ? 1.0 - there : 0.0;
    return Eigen::Vector3d(-0.5, 0.2 * y, 0.3 + 0.15 * z);
  };
  TargetPredictor waypoints(memory_s, true);
  TargetPredictor rest(memory_s, true);
  for (double t_s = 0.0; t_s < 12.0; t_s += 0.1) {
    watch(waypoints, corners, t_s, t_s + 0.1);
    watch(
        rest, [](double) { return Eigen::Vector3d(-0.5, 0.0, 0.3); }, t_s, t_s + 0.1);
    ASSERT_FALSE(waypoints.sinusoid().has_value()) << t_s;
    ASSERT_FALSE(rest.sinusoid().has_value()) << t_s;
  }
}

TEST(TargetPredictor, PredictsFreeFallAndDropsItAtTheCatch) {
  // Held, thrown upward at 2 m/s, caught.
  const Path thrown = [](double t_s) {
    const double flight_s = std::clamp(t_s - 0.5, 0.0, 0.4);
    return Eigen::Vector3d(-0.6, 0.3 * flight_s, 0.2 + 2.0 * flight_s - 0.5 * 9.81 * flight_s * flight_s);
  };
  TargetPredictor predictor(memory_s, true);
  watch(predictor, thrown, 0.0, 0.75);
  EXPECT_TRUE(predictor.falls());
  const double fitted_m = sideways_error_m(predictor, thrown, 0.75, 0.1);
  EXPECT_LT(fitted_m, 0.02);
  watch(predictor, thrown, 0.75, 1.3);
  EXPECT_FALSE(predictor.falls());
  EXPECT_LT(sideways_error_m(predictor, thrown, 1.3, 0.05), 0.005);
}

}  // namespace
}  // namespace saccade
