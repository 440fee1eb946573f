#include "sim/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

constexpr std::uint64_t seed = 7;

TrajectoryConfig still(TrajectoryConfig config) {
  config.sway_m = 0.0;
  return config;
}

TrajectoryConfig square(SpeedProfile profile) {
  TrajectoryConfig config;
  config.kind = TrajectoryKind::waypoints;
  config.profile = profile;
  config.start_s = 0.5;
  config.dwell_s = 0.25;
  config.points_m = {{-0.5, -0.12, 0.25}, {-0.5, -0.12, 0.45}, {-0.5, 0.12, 0.45}, {-0.5, 0.12, 0.25}};
  return config;
}

Eigen::Vector3d point(const TrajectoryConfig& config, std::size_t i) { return config.points_m[i]; }

/// Largest |d^n x / dt^n| over [0, end), by differences of `step_us`.
double largest_derivative(const Trajectory& trajectory, int order, std::int64_t end_us,
                          std::int64_t step_us) {
  double largest = 0.0;
  for (std::int64_t t = order * step_us; t < end_us; t += step_us) {
    Eigen::Vector3d difference = Eigen::Vector3d::Zero();
    double binomial = 1.0;
    for (int k = 0; k <= order; ++k) {
      difference += (k % 2 == 0 ? binomial : -binomial) * trajectory.position_m(t - k * step_us);
      binomial *= static_cast<double>(order - k) / (k + 1);
    }
    largest = std::max(largest, difference.norm() / std::pow(static_cast<double>(step_us) * 1e-6, order));
  }
  return largest;
}

TEST(Trajectory, HoldsTheBallAtItsPoint) {
  TrajectoryConfig config;
  config.points_m = {{-0.4, 0.05, 0.3}};
  const Trajectory trajectory(still(config), seed);
  for (std::int64_t t = 0; t < 10'000'000; t += 333'333) {
    EXPECT_EQ(trajectory.position_m(t), point(config, 0));
  }
  EXPECT_EQ(trajectory.first_motion_us(), 0);
}

class WaypointProfile : public testing::TestWithParam<SpeedProfile> {};
INSTANTIATE_TEST_SUITE_P(Both, WaypointProfile,
                         testing::Values(SpeedProfile::minimum_jerk, SpeedProfile::constant_speed),
                         [](const auto& test) { return std::string(word_of(test.param)); });

TEST_P(WaypointProfile, WaitsAtTheFirstPointUntilItStarts) {
  const TrajectoryConfig config = still(square(GetParam()));
  const Trajectory trajectory(config, seed);
  EXPECT_EQ(trajectory.first_motion_us(), 500'000);
  EXPECT_EQ(trajectory.position_m(500'000), point(config, 0));
  EXPECT_NE(trajectory.position_m(520'000), point(config, 0));
}

TEST_P(WaypointProfile, ReachesEveryPointAndRestsThere) {
  const TrajectoryConfig config = still(square(GetParam()));
  const Trajectory trajectory(config, seed);
  const double ramp_s = GetParam() == SpeedProfile::constant_speed ? config.ramp_s : 0.0;
  double t_s = config.start_s;
  for (std::size_t i = 1; i < config.points_m.size(); ++i) {
    t_s += (point(config, i) - point(config, i - 1)).norm() / config.speed_m_s + ramp_s;
    for (const double rest : {0.0001, 0.5 * config.dwell_s, config.dwell_s}) {
      const auto t_us = static_cast<std::int64_t>((t_s + rest) * 1e6);
      EXPECT_LT((trajectory.position_m(t_us) - point(config, i)).norm(), 1e-9) << "point " << i;
    }
    t_s += config.dwell_s;
  }
}

TEST_P(WaypointProfile, StaysOnTheStraightLineBetweenItsPoints) {
  const TrajectoryConfig config = still(square(GetParam()));
  const Trajectory trajectory(config, seed);
  for (std::int64_t t = 0; t < 10'000'000; t += 1000) {
    const Eigen::Vector3d p = trajectory.position_m(t);
    double nearest = 1.0;
    for (std::size_t i = 1; i < config.points_m.size(); ++i) {
      const Eigen::Vector3d a = point(config, i - 1);
      const Eigen::Vector3d b = point(config, i);
      const double along = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (p - a - along * (b - a)).norm());
    }
    ASSERT_LT(nearest, 1e-12) << "at " << t;
  }
}

TEST_P(WaypointProfile, HasTheConfiguredSpeed) {
  const TrajectoryConfig config = still(square(GetParam()));
  const double peak = largest_derivative(Trajectory(config, seed), 1, 10'000'000, 1000);
  EXPECT_NEAR(peak, (GetParam() == SpeedProfile::constant_speed ? 1.0 : 1.875) * config.speed_m_s, 1e-4);
}

TEST_P(WaypointProfile, HasNoJumpInItsAcceleration) {
  // Acceleration changes by jerk * step; a jump would make the third difference grow as the step shrinks.
  const Trajectory trajectory(still(square(GetParam())), seed);
  const double coarse = largest_derivative(trajectory, 3, 10'000'000, 2000);
  const double fine = largest_derivative(trajectory, 3, 10'000'000, 500);
  EXPECT_LT(fine, 1.1 * coarse);
}

TEST_P(WaypointProfile, ReturnsToTheFirstPointWhenItLoops) {
  TrajectoryConfig config = still(square(GetParam()));
  config.loop = true;
  const Trajectory trajectory(config, seed);
  const double moving_s =
      0.88 / config.speed_m_s + (GetParam() == SpeedProfile::constant_speed ? 4 * config.ramp_s : 0.0);
  const auto lap_us = static_cast<std::int64_t>(std::llround((moving_s + 4 * config.dwell_s) * 1e6));
  EXPECT_LT((trajectory.position_m(500'000 + lap_us - 1000) - point(config, 0)).norm(), 1e-9);
  for (std::int64_t t = 500'000; t < 500'000 + lap_us; t += 77'000) {
    EXPECT_LT((trajectory.position_m(t) - trajectory.position_m(t + 3 * lap_us)).norm(), 1e-9);
  }
}

TEST(Trajectory, IsSlowerOnASegmentTooShortForFullSpeed) {
  TrajectoryConfig config = square(SpeedProfile::constant_speed);
  config.points_m = {{-0.5, 0.0, 0.3}, {-0.5, 0.005, 0.3}};
  const Trajectory trajectory(still(config), seed);
  EXPECT_LT(largest_derivative(trajectory, 1, 3'000'000, 1000), config.speed_m_s);
  EXPECT_LT((trajectory.position_m(3'000'000) - point(config, 1)).norm(), 1e-12);
}

TEST(Trajectory, CirclesAtItsFrequency) {
  TrajectoryConfig config;
  config.kind = TrajectoryKind::circle;
  config.start_s = 1.0;
  config.frequency_hz = 0.5;
  const Trajectory trajectory(still(config), seed);
  const Eigen::Vector3d centre(-0.5, 0.0, 0.347);
  EXPECT_EQ(trajectory.first_motion_us(), 1'000'000);
  EXPECT_EQ(trajectory.position_m(1'000'000), Eigen::Vector3d(-0.5, 0.1, 0.347));
  for (std::int64_t t = 0; t < 8'000'000; t += 10'000) {
    ASSERT_NEAR((trajectory.position_m(t) - centre).norm(), 0.1, 1e-12);
  }
  EXPECT_LT((trajectory.position_m(3'000'000) - trajectory.position_m(5'000'000)).norm(), 1e-9);
  EXPECT_NEAR(largest_derivative(trajectory, 1, 6'000'000, 1000), 2.0 * M_PI * 0.5 * 0.1, 1e-4);
  EXPECT_LT(largest_derivative(trajectory, 3, 6'000'000, 500),
            1.1 * largest_derivative(trajectory, 3, 6'000'000, 2000));
}

TEST(Trajectory, FallsFreelyBetweenThrowAndCatch) {
  TrajectoryConfig config;
  config.kind = TrajectoryKind::waypoints;
  config.profile = SpeedProfile::free_fall;
  config.points_m = {{-0.5, 0.0, 0.3}, {-0.5, 0.4, 0.3}};
  config.speed_m_s = 1.0;
  config.sway_m = 0.0;
  const Trajectory trajectory(config, 1);
  const double step_s = 0.01;
  for (int i = 2; i < 38; ++i) {
    const auto at = [&](int k) { return trajectory.position_m(10'000 * (i + k)); };
    const Eigen::Vector3d acceleration = (at(1) - 2.0 * at(0) + at(-1)) / (step_s * step_s);
    EXPECT_NEAR(acceleration.z(), -9.81, 1e-6);
    EXPECT_NEAR(acceleration.y(), 0.0, 1e-6);
  }
  EXPECT_NEAR((trajectory.position_m(400'000) - config.points_m[1]).norm(), 0.0, 1e-12);
}

TEST(Trajectory, SwaysSlowlyWithTheConfiguredRmsOnEveryAxis) {
  TrajectoryConfig config;
  config.sway_m = 0.002;
  for (std::uint64_t s = 0; s < 5; ++s) {
    const Trajectory trajectory(config, s);
    Eigen::Array3d squares = Eigen::Array3d::Zero();
    int count = 0;
    for (std::int64_t t = 2'000'000; t < 302'000'000; t += 10'000, ++count) {
      squares += (trajectory.position_m(t) - point(config, 0)).array().square();
    }
    // Over 300 s the beats of eight terms average out to a few per cent.
    EXPECT_NEAR((squares / count).sqrt().maxCoeff(), 0.002, 0.0002);
    EXPECT_NEAR((squares / count).sqrt().minCoeff(), 0.002, 0.0002);
    // A term at f has amplitude ~ 1/f: no axis can be faster than 2 pi sway sqrt(2 * 8) if all f were 3 Hz.
    EXPECT_LT(largest_derivative(trajectory, 1, 60'000'000, 1000), 3.0 * 2.0 * M_PI * 3.0 * 0.002 * 2.0);
  }
}

TEST(Trajectory, SwayGrowsSmoothlyFromZero) {
  const TrajectoryConfig config;
  const Trajectory trajectory(config, seed);
  EXPECT_EQ(trajectory.position_m(0), point(config, 0));
  EXPECT_EQ(trajectory.position_m(-5000), point(config, 0));
  EXPECT_LT(largest_derivative(trajectory, 2, 5000, 1000), 1e-3);
  EXPECT_LT(largest_derivative(trajectory, 3, 5'000'000, 500),
            1.1 * largest_derivative(trajectory, 3, 5'000'000, 2000));
}

TEST(Trajectory, SwaysDifferentlyWithAnotherSeedAndTheSameWithTheSame) {
  const TrajectoryConfig config;
  EXPECT_EQ(Trajectory(config, 1).position_m(3'210'000), Trajectory(config, 1).position_m(3'210'000));
  EXPECT_GT(
      (Trajectory(config, 1).position_m(3'210'000) - Trajectory(config, 2).position_m(3'210'000)).norm(),
      1e-5);
}

TEST(Trajectory, RejectsConfigurationsOutOfRange) {
  TrajectoryConfig config = square(SpeedProfile::minimum_jerk);
  config.speed_m_s = 0.0;
  config.points_m[1] = config.points_m[0];
  config.points_m[3].x() = 6.0;
  config.kind = TrajectoryKind::waypoints;
  try {
    const Trajectory trajectory(config, seed);
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 3u) << error.what();
    EXPECT_THAT(error.what(), testing::HasSubstr("trajectory.speed_m_s"));
  }
  config.kind = TrajectoryKind{7};
  EXPECT_THROW(Trajectory(config, seed), InputError);
  config.kind = TrajectoryKind::hold;
  EXPECT_THROW(Trajectory(config, seed), InputError);
}

}  // namespace
}  // namespace saccade
