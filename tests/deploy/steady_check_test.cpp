#include "apps/deploy/steady_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "core/config.h"
#include "core/error.h"
#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A fake robot whose camera was heard, and whose joints were read, when the functions say so.
class Unsteady final : public Robot, public EventSource, private HeadPort {
 public:
  using Heard = std::function<std::int64_t(std::int64_t now_us)>;
  Unsteady(Heard packet, Heard reading)
      : world_(script()), packet_(std::move(packet)), reading_(std::move(reading)) {}

  Clock& clock() override { return world_; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return reading_ ? this : nullptr; }
  [[nodiscard]] ImageSize image_size() const override { return world_.image_size(); }
  PortStatus read_until(std::int64_t, std::vector<Event>&) override { return PortStatus::ok; }
  [[nodiscard]] std::int64_t heard_us() const override { return packet_(world_.now_us()); }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

 private:
  static FakeRobotScript script() {
    FakeRobotScript script;
    script.limits = genova02_limits();
    return script;
  }
  [[nodiscard]] JointLimits limits() const override { return world_.limits(); }
  PortStatus read(HeadState& state) override {
    const PortStatus status = world_.read(state);
    state.t_us = reading_(world_.now_us());
    return status;
  }
  CommandResult command(const HeadCommand&) override { return {}; }
  PortStatus stop() override { return PortStatus::ok; }

  FakeRobot world_;
  Heard packet_, reading_;
};

/// Something that comes every `period_us`.
Unsteady::Heard each(std::int64_t period_us) {
  return [period_us](std::int64_t now_us) { return now_us - now_us % period_us; };
}

TEST(SteadyCheck, WhatComesWithinHalfOfItsBoundPasses) {
  Unsteady robot(each(20'000), each(30'000));
  const auto checks = steady_checks(robot, {});
  ASSERT_EQ(checks.size(), 2U);
  EXPECT_TRUE(checks[0].passed);
  EXPECT_EQ(checks[0].found, "the newest packet was at most 19.0 ms old");
  EXPECT_TRUE(checks[1].passed);
  EXPECT_EQ(checks[1].found, "the newest reading was at most 29.0 ms old");
  EXPECT_EQ(robot.clock().now_us(), 500'000);
}

TEST(SteadyCheck, LongerGapsFailWithFigureBoundAndKey) {
  Unsteady robot(each(45'000), each(10'000));
  const auto checks = steady_checks(robot, {});
  ASSERT_EQ(checks.size(), 2U);
  EXPECT_FALSE(checks[0].passed);
  EXPECT_THAT(checks[0].found, AllOf(HasSubstr("at most 44.0 ms old"), HasSubstr("expected 30 or less"),
                                     HasSubstr("deploy.watchdog.camera_silent_ms")));
  EXPECT_TRUE(checks[1].passed);

  Unsteady old(each(10'000), each(100'000));
  WatchdogConfig bounds;
  bounds.joints_stale_ms = 40.0;
  const auto readings = steady_checks(old, bounds);
  EXPECT_TRUE(readings[0].passed);
  EXPECT_FALSE(readings[1].passed);
  EXPECT_THAT(readings[1].found, AllOf(HasSubstr("at most 99.0 ms old"), HasSubstr("expected 20 or less"),
                                       HasSubstr("deploy.watchdog.joints_stale_ms")));
}

TEST(SteadyCheck, ADelayAtTheStartMayPass) {
  const auto late_start = [](std::int64_t now_us) { return now_us < 700'000 ? std::int64_t{0} : now_us; };
  Unsteady robot(each(10'000), late_start);
  for (const StartUpCheck& check : steady_checks(robot, {})) EXPECT_TRUE(check.passed) << check.found;
  EXPECT_EQ(robot.clock().now_us(), 1'500'000) << "the third half second is steady";
}

TEST(SteadyCheck, ACameraAloneHasNoReadings) {
  Unsteady robot(each(10'000), {});
  EXPECT_EQ(steady_checks(robot, {}).size(), 1U);
}

TEST(HaltsCheck, SaysOnAVirtualMachineHowLongABoundIsSafe) {
  WatchdogConfig watchdog;
  EXPECT_EQ(halts_check(false, watchdog).found, "one of more than 20 ms stops the head");
  EXPECT_THAT(halts_check(true, watchdog).found,
              AllOf(HasSubstr("tick_late_ms and hang_ms of deploy.watchdog"), HasSubstr("up to 38 here")));
  watchdog.tick_late_ms = watchdog.hang_ms = 38.0;
  EXPECT_NO_THROW(check_config("watchdog", watchdog));
  EXPECT_EQ(halts_check(true, watchdog).found, "one of more than 38 ms stops the head");
  watchdog.hang_ms = 38.1;
  EXPECT_THROW(check_config("watchdog", watchdog), InputError);
}

}  // namespace
}  // namespace saccade
