#include "robot/fake/fake_robot.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/robot/scripted_world.h"

namespace saccade {
namespace {

TEST(FakeRobot, FollowsItsReferenceWithAFirstOrderLagForAnySteps) {
  FakeRobotScript script = scripted_world(0);
  script.lag_s = 0.08;
  FakeRobot coarse(script);
  FakeRobot fine(script);
  const HeadCommand reference = HeadCommand::Constant(0.5);
  coarse.command(reference);
  fine.command(reference);
  coarse.wait_until(80'000);
  for (std::int64_t t_us = 1000; t_us <= 80'000; t_us += 1000) fine.wait_until(t_us);
  HeadState a;
  HeadState b;
  coarse.read(a);
  fine.read(b);
  // After one time constant 1 - 1/e of the way from -0.2 to 0.5 is done, at a speed of what is left per lag.
  const double expected = 0.5 - 0.7 / std::exp(1.0);
  for (int joint = neck_pitch; joint < joint_count; ++joint) {
    EXPECT_NEAR(a.position_rad[joint], expected, 1e-12);
    EXPECT_NEAR(b.position_rad[joint], expected, 1e-12);
    EXPECT_NEAR(a.velocity_rad_s[joint], (0.5 - expected) / 0.08, 1e-9);
  }
  EXPECT_EQ(a.position_rad.head<torso_joint_count>(), script.start_rad.head<torso_joint_count>());
}

TEST(FakeRobot, IsLostOnEveryPortFromTheScriptedTimeOn) {
  FakeRobotScript script = scripted_world(0);
  script.lost_us = 100'000;
  FakeRobot robot(script);
  std::vector<Event> events;
  EXPECT_EQ(robot.wait_until(99'999), PortStatus::ok);
  EXPECT_EQ(robot.read_until(99'000, events), PortStatus::ok);
  EXPECT_EQ(robot.command(HeadCommand::Constant(0.1)).status, PortStatus::ok);
  const std::size_t count = events.size();
  EXPECT_GT(count, 0u);

  EXPECT_EQ(robot.wait_until(100'000), PortStatus::lost);
  EXPECT_EQ(robot.now_us(), 99'999);
  EXPECT_EQ(robot.wait_until(0), PortStatus::lost);
  EXPECT_EQ(robot.read_until(99'999, events), PortStatus::lost);
  EXPECT_EQ(events.size(), count);
  HeadState state;
  state.t_us = 42;
  EXPECT_EQ(robot.read(state), PortStatus::lost);
  EXPECT_EQ(state.t_us, 42);
  EXPECT_EQ(robot.command(HeadCommand::Constant(0.3)).status, PortStatus::lost);
  EXPECT_EQ(robot.reference_rad(), HeadCommand::Constant(0.1));
}

TEST(FakeRobot, RepeatsTheReadingOfFrozenEncodersWhileTheHeadMoves) {
  FakeRobotScript script = scripted_world(0);
  FakeRobot whole(script);
  script.freeze_us = 50'500;
  FakeRobot frozen(script);
  HeadState at_freeze;
  HeadState later;
  for (FakeRobot* robot : {&whole, &frozen}) robot->command(HeadCommand::Constant(0.5));
  whole.wait_until(50'500);
  whole.read(at_freeze);
  for (const std::int64_t t_us : {20'000, 80'000, 200'000}) frozen.wait_until(t_us);
  frozen.read(later);
  EXPECT_EQ(later.t_us, 50'500);
  EXPECT_TRUE(later.position_rad.isApprox(at_freeze.position_rad, 1e-12));
  EXPECT_EQ(frozen.now_us(), 200'000);
}

TEST(FakeRobot, DeliversEventsWithTheScriptedDelay) {
  FakeRobotScript script;
  script.events = {{1000, 1, 1, true, 0}, {2000, 2, 2, true, 0}};
  script.lateness_us = 1500;
  FakeRobot robot(script);
  std::vector<Event> events;
  robot.wait_until(2499);
  robot.read_until(2499, events);
  EXPECT_TRUE(events.empty());
  robot.wait_until(3500);
  robot.read_until(2500, events);
  EXPECT_EQ(events.size(), 1u);
  robot.read_until(3500, events);
  EXPECT_EQ(events, script.events);
}

TEST(FakeRobotDeathTest, ReadingFutureEventsAndUnsortedScriptsAreErrors) {
  FakeRobot robot(scripted_world(0));
  std::vector<Event> events;
  EXPECT_DEATH(robot.read_until(1, events), "t_us <= now_us_");
  FakeRobotScript script;
  script.events = {{2, 1, 1, true, 0}, {1, 1, 1, true, 0}};
  EXPECT_DEATH(FakeRobot{script}, "is_sorted");
}

TEST(FakeRobot, OffersTheNewestScriptedReadingOfItsInertialSensor) {
  FakeRobotScript script = scripted_world(0);
  EXPECT_EQ(FakeRobot(script).imu(), nullptr);
  script.imu = {{2000, {1.0, 0.0, 0.0}, Eigen::Vector3d::Zero()},
                {4000, {2.0, 0.0, 0.0}, Eigen::Vector3d::Zero()}};
  script.lost_us = 6000;
  FakeRobot robot(script);
  ASSERT_NE(robot.imu(), nullptr);
  ImuReading reading;
  robot.wait_until(1000);
  EXPECT_EQ(robot.imu()->read_imu(reading), PortStatus::ok);
  EXPECT_EQ(reading.t_us, 0);
  robot.wait_until(3999);
  robot.imu()->read_imu(reading);
  EXPECT_EQ(reading.angular_velocity_rad_s.x(), 1.0);
  robot.wait_until(4000);
  robot.imu()->read_imu(reading);
  EXPECT_EQ(reading.angular_velocity_rad_s.x(), 2.0);
  robot.wait_until(6000);
  EXPECT_EQ(robot.imu()->read_imu(reading), PortStatus::lost);
}

}  // namespace
}  // namespace saccade
