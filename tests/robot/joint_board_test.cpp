#include "robot/joint_board.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace saccade {
namespace {

constexpr double dt_s = 0.001;

/// Two joints whose measured positions are their references of one step ago.
class Board {
 public:
  explicit Board(bool movable = true) : board({{-0.5, 0.3, 2.0}, {-1.0, 1.0, 5.0}}, measured_rad, movable) {}

  void run(double duration_s) {
    for (int i = 0; i < std::lround(duration_s / dt_s); ++i) measured_rad = board.step(measured_rad, dt_s);
  }

  Eigen::VectorXd measured_rad = Eigen::Vector2d(0.1, -0.2);
  JointBoard board;
};

TEST(JointBoard, HoldsItsPositionAndRejectsCommandsWhileIdle) {
  Board b;
  ASSERT_TRUE(b.board.set_mode(0, JointMode::idle));
  EXPECT_FALSE(b.board.set_reference(0, 0.2));
  EXPECT_FALSE(b.board.move_to(0, 0.2));
  EXPECT_FALSE(b.board.set_velocity(0, 0.2));
  b.run(0.5);
  EXPECT_EQ(b.measured_rad, Eigen::Vector2d(0.1, -0.2));
}

TEST(JointBoard, AcceptsOnlyCommandsForTheModeOfTheJoint) {
  Board b;
  ASSERT_TRUE(b.board.set_mode(0, JointMode::direct));
  ASSERT_TRUE(b.board.set_mode(1, JointMode::position));
  EXPECT_TRUE(b.board.set_reference(0, 0.2));
  EXPECT_FALSE(b.board.move_to(0, 0.2));
  EXPECT_TRUE(b.board.move_to(1, 0.2));
  EXPECT_FALSE(b.board.set_reference(1, 0.2));
}

TEST(JointBoard, ClampsReferencesToTheLimits) {
  Board b;
  b.board.set_mode(0, JointMode::direct);
  EXPECT_TRUE(b.board.set_reference(0, 0.8));
  EXPECT_EQ(b.board.step(b.measured_rad, dt_s)[0], 0.3);
  EXPECT_TRUE(b.board.set_reference(0, -7.0));
  EXPECT_EQ(b.board.step(b.measured_rad, dt_s)[0], -0.5);
  EXPECT_FALSE(b.board.set_reference(0, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(b.board.step(b.measured_rad, dt_s)[0], -0.5);
}

TEST(JointBoard, APositionMoveTakesDistanceBySpeedAndDoesNotOvershoot) {
  Board b;
  b.board.set_mode(1, JointMode::position);
  b.board.set_speed(1, 0.5);
  b.board.move_to(1, 0.8);  // 1 rad: 2 s
  double fastest_rad_s = 0.0;
  for (int i = 0; i < 1999; ++i) {
    const double before = b.measured_rad[1];
    b.run(dt_s);
    fastest_rad_s = std::max(fastest_rad_s, (b.measured_rad[1] - before) / dt_s);
    EXPECT_GE(b.measured_rad[1], before);
  }
  EXPECT_TRUE(b.board.moving(1));
  b.run(2 * dt_s);
  EXPECT_FALSE(b.board.moving(1));
  EXPECT_EQ(b.measured_rad[1], 0.8);
  EXPECT_NEAR(fastest_rad_s, 1.875 * 0.5, 0.01);  // of a minimum-jerk move
}

TEST(JointBoard, AVelocityMovesTheJointUpToTheLimit) {
  Board b;
  b.board.set_mode(0, JointMode::velocity);
  b.board.set_velocity(0, 1.0);
  b.run(0.1);
  EXPECT_NEAR(b.measured_rad[0], 0.1 + 0.1, 0.04);  // 57 ms of it speeding up
  for (int i = 0; i < 10; ++i) {
    b.board.set_velocity(0, 1.0);
    b.run(0.05);
  }
  EXPECT_EQ(b.measured_rad[0], 0.3);
}

TEST(JointBoard, AVelocityThatIsNotRepeatedEndsAfterTheTimeout) {
  Board b;
  b.board.set_mode(1, JointMode::velocity);
  b.board.set_acceleration(1, 1e6);
  b.board.set_velocity(1, 1.0);
  b.run(0.5);
  EXPECT_NEAR(b.measured_rad[1], -0.2 + JointBoard::velocity_timeout_s, 2e-3);
}

TEST(JointBoard, InMixedModeVelocitiesAddToAMove) {
  Board b;
  b.board.set_mode(1, JointMode::mixed);
  b.board.set_speed(1, 0.5);
  ASSERT_TRUE(b.board.move_to(1, 0.3));  // 0.5 rad: 1 s
  for (int i = 0; i < 22; ++i) {         // as iKinGazeCtrl: during a saccade it sends velocities of 0
    EXPECT_TRUE(b.board.set_velocity(1, 0.0));
    b.run(0.05);
  }
  EXPECT_FALSE(b.board.moving(1));
  EXPECT_NEAR(b.measured_rad[1], 0.3, 1e-9);
  b.board.set_acceleration(1, 1e6);
  ASSERT_TRUE(b.board.move_to(1, -0.2));
  for (int i = 0; i < 22; ++i) {
    EXPECT_TRUE(b.board.set_velocity(1, 0.1));
    b.run(0.05);
  }
  EXPECT_NEAR(b.measured_rad[1], -0.2 + 1.1 * 0.1, 2e-3);
}

TEST(JointBoard, HoldsTheMeasuredPositionAfterAStopAndAChangeOfMode) {
  Board b;
  b.board.set_mode(1, JointMode::position);
  b.board.set_speed(1, 0.5);
  b.board.move_to(1, 0.8);
  b.run(1.0);
  const double there = b.measured_rad[1];
  b.board.stop(1);
  b.run(0.5);
  EXPECT_NEAR(b.measured_rad[1], there, 1e-3);
  b.board.move_to(1, 0.8);
  b.run(0.3);
  b.board.set_mode(1, JointMode::direct);
  const double then = b.measured_rad[1];
  b.run(0.3);
  EXPECT_NEAR(b.measured_rad[1], then, 1e-3);
}

TEST(JointBoard, JointsThatAreNotMovableStayIdle) {
  Board b(false);
  EXPECT_FALSE(b.board.set_mode(0, JointMode::direct));
  EXPECT_TRUE(b.board.set_mode(0, JointMode::idle));
  EXPECT_FALSE(b.board.set_reference(0, 0.2));
  b.run(0.1);
  EXPECT_EQ(b.measured_rad[0], 0.1);
}

}  // namespace
}  // namespace saccade
