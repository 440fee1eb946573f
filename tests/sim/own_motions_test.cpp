#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "sim/flicker.h"
#include "sim/free_body.h"
#include "sim/motion_track.h"
#include "sim/pendulum.h"

namespace saccade {
namespace {

constexpr double gravity_m_s2 = 9.81;

TEST(Pendulum, KeepsItsEnergy) {
  PendulumConfig config;
  config.amplitude_deg = 70.0;
  const Pendulum pendulum(config);
  const auto energy = [&](double t_s) {
    constexpr double h_s = 1e-5;
    const double speed = (pendulum.angle_rad(t_s + h_s) - pendulum.angle_rad(t_s - h_s)) / (2.0 * h_s);
    return 0.5 * config.length_m * speed * speed - gravity_m_s2 * std::cos(pendulum.angle_rad(t_s));
  };
  const double start = -gravity_m_s2 * std::cos(70.0 * std::numbers::pi / 180.0);
  for (double t_s = 0.01; t_s < 20.0; t_s += 0.013) ASSERT_NEAR(energy(t_s), start, 1e-5) << t_s;
}

TEST(Pendulum, SwingsAsASmallOneAtSmallAngles) {
  PendulumConfig config;
  config.amplitude_deg = 0.5;
  const Pendulum pendulum(config);
  const double angular = std::sqrt(gravity_m_s2 / config.length_m);
  for (double t_s = 0.0; t_s < 5.0; t_s += 0.01) {
    EXPECT_NEAR(pendulum.angle_rad(t_s), 0.5 * std::numbers::pi / 180.0 * std::cos(angular * t_s), 1e-6);
  }
}

TEST(Pendulum, KeepsTheRodBetweenPivotAndObject) {
  PendulumConfig config;
  config.amplitude_deg = 40.0;
  config.plane_deg = 30.0;
  const Pendulum pendulum(config);
  for (double t_s = 0.0; t_s < 3.0; t_s += 0.1) {
    const Eigen::Vector3d up = pendulum.turn(t_s) * Eigen::Vector3d::UnitZ();
    EXPECT_LT((pendulum.position_m(t_s) + config.length_m * up - config.pivot_m).norm(), 1e-12);
  }
}

class Bounce : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Ratios, Bounce, testing::Values(0.3, 0.5, 0.7, 0.9), [](const auto& test) {
  return "Of" + std::to_string(std::lround(100 * test.param));
});

TEST_P(Bounce, ReturnsTheShareOfTheSpeedThatIsAskedFor) {
  BallisticConfig config;
  config.from_m = {-0.6, 0.0, 0.5475};  // the ball's lowest point 0.5 m above the surface
  config.velocity_m_s.setZero();
  config.contact.bounce = GetParam();
  config.lasts_s = 1.2;
  const MotionTrack track = ballistic_motion(config, {}, "test");
  double highest_m = 0.0;
  const double falls_s = std::sqrt(2.0 * 0.5 / gravity_m_s2);
  const double flies_s = 2.0 * GetParam() * falls_s;
  for (double t_s = falls_s + 0.01; t_s < falls_s + flies_s; t_s += 0.001) {
    highest_m = std::max(highest_m, track.position_m(t_s).z() - 0.0475);
  }
  // Height goes with the square of the speed. 4 % of the speed: the contact lasts 4 ms, during which gravity acts too.
  EXPECT_NEAR(std::sqrt(highest_m / 0.5), GetParam(), 0.04 * GetParam());
}

TEST(Ballistic, FliesAParabolaBeforeItBounces) {
  BallisticConfig config;
  const MotionTrack track = ballistic_motion(config, {}, "test");
  for (double t_s = 0.0; t_s < 0.3; t_s += 0.01) {
    const Eigen::Vector3d free =
        config.from_m + t_s * config.velocity_m_s - 0.5 * gravity_m_s2 * t_s * t_s * Eigen::Vector3d::UnitZ();
    EXPECT_LT((track.position_m(t_s) - free).norm(), 5e-4)
        << t_s;  // steps of 0.1 ms: g t dt / 2 = 0.15 mm at 0.3 s
  }
}

TEST(Ballistic, EndsOnItsSurface) {
  BallisticConfig config;
  config.lasts_s = 20.0;
  const MotionTrack track = ballistic_motion(config, {}, "test");
  EXPECT_NEAR(track.samples().back().position_m.z(), 0.0475, 1e-3);
}

TEST(Ballistic, GivesTheSameBytesTwice) {
  const BallisticConfig config;
  const MotionTrack a = ballistic_motion(config, {}, "test");
  const MotionTrack b = ballistic_motion(config, {}, "test");
  ASSERT_EQ(a.samples().size(), b.samples().size());
  for (std::size_t i = 0; i < a.samples().size(); ++i) {
    ASSERT_EQ(a.samples()[i].position_m, b.samples()[i].position_m);
    ASSERT_EQ(a.samples()[i].turn.coeffs(), b.samples()[i].turn.coeffs());
  }
}

TEST(Ballistic, RefusesABodyInsideItsSurface) {
  BallisticConfig config;
  config.from_m.z() = 0.02;
  try {
    static_cast<void>(ballistic_motion(config, {}, "ball.trajectory"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("ball.trajectory.from_m: found 0.02 m above the surface"));
  }
}

TEST(Pushed, SlidesAsFarAsFrictionLetsIt) {
  PushConfig config;
  config.push_m_s = {0.0, 1.0};
  config.push_s = 0.01;
  config.friction = 0.3;
  const BodyShape box{"", "<geom type=\"box\" size=\"0.1 0.1 0.02\"/>"};
  const MotionTrack track = pushed_motion(config, box, "test");
  // While pushed the body loses mu g of the push's 100 m/s^2; then it slides v^2 / (2 mu g).
  const double speed_m_s = 1.0 - config.friction * gravity_m_s2 * config.push_s;
  const double way_m =
      0.5 * speed_m_s * config.push_s + speed_m_s * speed_m_s / (2.0 * config.friction * gravity_m_s2);
  const Eigen::Vector3d moved = track.samples().back().position_m - config.from_m;
  EXPECT_NEAR(moved.y(), way_m, 0.03 * way_m);
  EXPECT_NEAR(moved.x(), 0.0, 1e-3);
  EXPECT_NEAR(moved.z(), 0.0, 1e-3);
  EXPECT_LT(track.samples().back().t_s, 2.0) << "rests";
}

TEST(Pushed, RollsABall) {
  const PushConfig config;
  const MotionTrack track = pushed_motion(config, {}, "test");
  const double way_m = (track.position_m(0.5) - track.position_m(0.4)).norm();
  const double turned = track.turn(0.4).angularDistance(track.turn(0.5));
  EXPECT_NEAR(0.0475 * turned, way_m, 0.05 * way_m);
}

TEST(Flicker, FollowsTwiceTheMainsFrequency) {
  FlickerConfig config;
  config.depth = 0.4;
  const Flicker flicker(config);
  for (std::int64_t t_us = 0; t_us < 10'000; t_us += 100) {
    const double sine = std::sin(2.0 * std::numbers::pi * 100.0 * 1e-6 * static_cast<double>(t_us));
    EXPECT_NEAR(flicker.factor(t_us), 0.8 + 0.2 * sine, 1e-12);
    EXPECT_NEAR(flicker.factor(t_us + 10'000), flicker.factor(t_us), 1e-12);
  }
}

TEST(Flicker, OfMainsNeedsTwentyFourImagesPerPeriod) {
  const Flicker flicker(FlickerConfig{});
  int images = 0;
  for (std::int64_t t_us = 0; t_us < 100'000; ++images) {
    const std::int64_t next_us = flicker.next_image_us(t_us);
    ASSERT_GT(next_us, t_us);
    t_us = next_us;
  }
  EXPECT_NEAR(images, 240, 1);
}

TEST(Flicker, OfPulsesIsOnForItsDutyAndNeedsAnImageAtTheEndOfEveryEdge) {
  FlickerConfig config;
  config.kind = FlickerKind::pwm;
  config.frequency_hz = 100.0;
  config.depth = 0.9;
  config.duty = 0.3;
  config.edge_ms = 0.2;
  const Flicker flicker(config);
  EXPECT_NEAR(flicker.factor(0), 0.1, 1e-12);
  EXPECT_NEAR(flicker.factor(100), 0.55, 1e-9);
  EXPECT_NEAR(flicker.factor(200), 1.0, 1e-9);
  EXPECT_NEAR(flicker.factor(2'999), 1.0, 1e-9);
  EXPECT_NEAR(flicker.factor(3'200), 0.1, 1e-9);
  EXPECT_NEAR(flicker.factor(9'999), 0.1, 1e-9);
  std::vector<std::int64_t> instants;
  for (std::int64_t t_us = 5; t_us < 20'000;) instants.push_back(t_us = flicker.next_image_us(t_us));
  EXPECT_THAT(instants, testing::ElementsAre(200, 3'000, 3'200, 10'000, 10'200, 13'000, 13'200, 20'000));
}

}  // namespace
}  // namespace saccade
