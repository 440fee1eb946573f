#include "sim/ball.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "sim/sim_robot.h"
#include "sim/world.h"

namespace saccade {
namespace {

WorldConfig world_with(const BallConfig& ball) {
  WorldConfig config;
  config.ball = ball;
  config.ball.trajectory.sway_m = 0.0;
  return config;
}

/// Share of a sphere that a pattern covers.
double covered(BallPattern pattern) {
  double sum = 0.0;
  constexpr int count = 20000;
  for (int i = 0; i < count; ++i) {  // a spiral with points of equal area
    const double z = 1.0 - (2.0 * i + 1.0) / count;
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    sum += pattern_cover(pattern, {r * std::cos(angle), r * std::sin(angle), z});
  }
  return sum / count;
}

TEST(Ball, PatternsCoverAShareOfItsSurface) {
  EXPECT_EQ(covered(BallPattern::plain), 0.0);
  EXPECT_NEAR(covered(BallPattern::striped), 0.5, 0.05);
  // Three belts of half-width 0.08 less their six crossings.
  EXPECT_NEAR(covered(BallPattern::seams), 3 * 0.08, 0.04);
  // Twelve caps of 0.36 rad.
  EXPECT_NEAR(covered(BallPattern::patches), 12 * 0.5 * (1 - std::cos(0.36)), 0.03);
}

TEST(Ball, EveryHandIsAModelThatLoads) {
  for (const auto& [hand, word] : words_of(Hand{})) {
    BallConfig ball;
    ball.hand = hand;
    ball.pattern = BallPattern::seams;
    const World world(world_with(ball), "", 1);
    EXPECT_GE(world.model().ngeom, 1) << word;
  }
}

TEST(Ball, EveryHandLeavesMostOfTheBallVisible) {
  for (const auto& [hand, word] : words_of(Hand{})) {
    for (const double diameter_m : {0.03, 0.06, 0.1}) {
      if (hand == Hand::fingers && diameter_m < 0.06) continue;  // fingers of natural size hide a small ball
      for (const double turn_deg : {-70.0, 0.0, 70.0}) {
        SimConfig config;
        config.world = world_with({});
        config.lab.clutter = Clutter::bare;  // what is behind the ball does not hide it
        config.world.ball.hand = hand;
        config.world.ball.diameter_m = diameter_m;
        config.world.ball.hand_turn_deg = turn_deg;
        std::optional<SimRobot> robot;
        try {
          robot.emplace(config, 1);
        } catch (const RunError& error) {
          GTEST_SKIP() << "NOT TESTED, there is no OpenGL: " << error.what();
        }
        EXPECT_GT(robot->truth().left.visible, 0.5)
            << word << ", " << diameter_m << " m, " << turn_deg << " deg";
      }
    }
  }
}

TEST(Ball, ItsPatternIsTurned) {
  BallConfig ball;
  ball.pattern = BallPattern::striped;
  ball.pattern_turn_deg = {90.0, 0.0, 0.0};
  const World world(world_with(ball), "", 1);
  const int geom = mj_name2id(&world.model(), mjOBJ_GEOM, "ball");
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(world.data().geom_xmat +
                                                                            9 * geom);
  EXPECT_NEAR(axes(1, 2), -1.0, 1e-9);  // the axis of the stripes, z, points along -y
}

TEST(Ball, OnlyABallWithoutAHandRolls) {
  BallConfig ball;
  ball.rolls = true;
  EXPECT_THROW(check_config("ball", ball), InputError);
  ball.hand = Hand::none;
  EXPECT_NO_THROW(check_config("ball", ball));
}

TEST(Ball, RollsWithoutSlipping) {
  const double radius_m = 0.05;
  const Eigen::Quaterniond turn = rolled({0.0, 0.01, 0.0}, radius_m);
  // The lowest point moves back, by as much as the ball moves forward.
  const Eigen::Vector3d lowest = turn * Eigen::Vector3d(0.0, 0.0, -radius_m);
  EXPECT_NEAR(lowest.y(), -radius_m * std::sin(0.2), 1e-12);
  EXPECT_NEAR(Eigen::AngleAxisd(turn).angle(), 0.2, 1e-12);
}

TEST(Ball, TurnsInTheWorldWhileItRolls) {
  BallConfig ball;
  ball.hand = Hand::none;
  ball.rolls = true;
  ball.trajectory.kind = TrajectoryKind::waypoints;
  ball.trajectory.points_m = {{-0.5, 0.0, 0.3}, {-0.5, 0.2, 0.3}};
  ball.trajectory.speed_m_s = 1.0;
  World world(world_with(ball), "", 1);
  for (int i = 0; i < 1000; ++i) world.step();
  const int geom = mj_name2id(&world.model(), mjOBJ_GEOM, "ball");
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(world.data().geom_xmat +
                                                                            9 * geom);
  const double angle = 0.2 / 0.0475 - std::numbers::pi;  // beyond half a turn
  EXPECT_NEAR(axes(2, 2), -std::cos(angle), 1e-6);
}

TEST(Ball, IsNeitherDrawnNorTrueWhereItIsAbsent) {
  SimConfig config;
  config.world = world_with({});
  config.world.ball.present = false;
  std::optional<SimRobot> robot;
  try {
    robot.emplace(config, 1);
  } catch (const RunError& error) {
    GTEST_SKIP() << "NOT TESTED, there is no OpenGL: " << error.what();
  }
  EXPECT_FALSE(robot->truth().left.circle.has_value());
  EXPECT_EQ(robot->truth().left.visible, 0.0);
  config.world.ball.present = true;
  const SimRobot with(config, 1);
  EXPECT_TRUE(with.truth().left.circle.has_value());
  EXPECT_GT(with.truth().left.visible, 0.5);
  const auto image = robot->left_eye().image();
  EXPECT_FALSE(std::equal(image.begin(), image.end(), with.left_eye().image().begin()));
}

TEST(Ball, AStripedBallHasBothColoursInItsImage) {
  SimConfig config;
  config.camera = config.camera.without_lens();
  config.world = world_with({});
  config.world.ball.hand = Hand::none;
  config.world.ball.rgb = {0.9, 0.9, 0.9};
  config.world.ball.pattern = BallPattern::striped;
  config.world.ball.pattern_rgb = {0.02, 0.02, 0.02};
  std::optional<SimRobot> robot;
  try {
    robot.emplace(config, 1);
  } catch (const RunError& error) {
    GTEST_SKIP() << "NOT TESTED, there is no OpenGL: " << error.what();
  }
  const auto circle = robot->truth().left.circle;
  ASSERT_TRUE(circle.has_value());
  int dark = 0;
  int bright = 0;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      if (std::hypot(x - circle->x_px, y - circle->y_px) > 0.8 * circle->r_px) continue;
      const float value = robot->left_eye().image()[static_cast<std::size_t>(128 * y + x)];
      dark += value < 40.0F ? 1 : 0;
      bright += value > 120.0F ? 1 : 0;
    }
  }
  EXPECT_GT(dark, 20);
  EXPECT_GT(bright, 20);
}

}  // namespace
}  // namespace saccade
