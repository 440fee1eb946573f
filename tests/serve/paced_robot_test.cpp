#include "apps/serve/paced_robot.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

TEST(PacedRobot, AdvancesItsClockNoFasterThanTheWallClock) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  FakeRobot fake(script);
  const auto begin = std::chrono::steady_clock::now();
  PacedRobot robot(fake);
  for (std::int64_t t_us = 1000; t_us <= 30'000; t_us += 1000) {
    ASSERT_EQ(robot.clock().wait_until(t_us), PortStatus::ok);
    ASSERT_EQ(robot.now_us(), t_us);
    const std::chrono::duration<double, std::micro> passed = std::chrono::steady_clock::now() - begin;
    ASSERT_GE(passed.count() + robot.slipped_s() * 1e6, static_cast<double>(t_us));
  }
  EXPECT_EQ(fake.now_us(), 30'000);
}

TEST(PacedRobot, KeepsTheSimulationStillWhileItIdles) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  FakeRobot fake(script);
  PacedRobot robot(fake);
  const auto begin = std::chrono::steady_clock::now();
  robot.idle(5'000);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(5));
  EXPECT_EQ(robot.now_us(), 0);
}

TEST(PacedRobot, ReportsHowLateAStepBegins) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  FakeRobot fake(script);
  std::vector<std::int64_t> lates_us;
  PacedRobot robot(fake, [&](std::int64_t late_us) { lates_us.push_back(late_us); });
  ASSERT_EQ(robot.wait_until(1'000), PortStatus::ok);
  std::this_thread::sleep_for(std::chrono::milliseconds(15));
  ASSERT_EQ(robot.wait_until(2'000), PortStatus::ok);
  ASSERT_EQ(lates_us.size(), 2U);
  EXPECT_GE(lates_us[0], 0);
  EXPECT_GE(lates_us[1], 13'000);
  EXPECT_GE(robot.longest_ms(), 15.0);
  EXPECT_GE(robot.latest_ms(), 13.0);
}

TEST(PacedRobot, PassesTheEndOfTheRobotOn) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  script.end_us = 2'000;
  FakeRobot fake(script);
  PacedRobot robot(fake);
  EXPECT_EQ(robot.wait_until(2'000), PortStatus::ok);
  EXPECT_EQ(robot.wait_until(3'000), PortStatus::ended);
}

}  // namespace
}  // namespace saccade
