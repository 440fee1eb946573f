#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "head/head_model.h"
#include "robot/ports.h"

/// Tests of the contract of robot/ports.h for any backend. A test program includes this file once and instantiates it:
///
///     INSTANTIATE_TEST_SUITE_P(Sim, PortConformance, testing::Values(backend), name_of_backend);

namespace saccade {

/// The ports of one robot and their owner. `head` is null if the robot has none.
struct RobotUnderTest {
  std::shared_ptr<void> owner;
  Clock* clock = nullptr;
  EventSource* events = nullptr;
  HeadPort* head = nullptr;
};

struct PortBackend {
  std::string name;
  /// Makes a new, activated robot, always in the same scene. It runs for at least 0.4 s and has events in the first
  /// 0.3 s. Two robots behave the same, so that they can be compared.
  std::function<RobotUnderTest()> make;
  bool moves_as_commanded = true;  ///< false for a recorded head
  bool ends = false;               ///< the run ends within 60 s
  std::int64_t lateness_us = 0;    ///< longest time between the time stamp of an event and its delivery
  /// Time passes by itself, so two robots differ. Tests that compare two robots are skipped.
  bool is_real_time = false;
  bool accepts_commands =
      true;  ///< false if another controller commands the joints: all commands are rejected
  bool moves_instantly = false;  ///< the head reaches a reference before it can be stopped
};

inline std::string name_of_backend(const testing::TestParamInfo<PortBackend>& backend) {
  return backend.param.name;
}
inline void PrintTo(const PortBackend& backend, std::ostream* out) { *out << backend.name; }

class PortConformance : public testing::TestWithParam<PortBackend> {
 protected:
  static constexpr std::int64_t tick_us = 1000;
  static constexpr int ticks = 300;

  RobotUnderTest make() const { return GetParam().make(); }

  /// As make(), or skips the test if the backend has no head.
  RobotUnderTest make_with_head() const {
    RobotUnderTest robot = make();
    if (robot.head == nullptr) skip_headless();
    return robot;
  }

  /// The middle of the limits moved towards the upper ones, by `share` of the way.
  static HeadCommand inside_limits(const HeadPort& head, double share) {
    const JointLimits limits = head.limits();
    const JointVector middle = 0.5 * (limits.min_rad + limits.max_rad);
    const JointVector& end = share < 0.0 ? limits.min_rad : limits.max_rad;  // met exactly at +-1
    return ((1.0 - std::abs(share)) * middle + std::abs(share) * end).tail<gaze_slots>();
  }

  /// Runs `ticks` ticks and reads the events after every `stride` of them.
  static std::vector<Event> run(const RobotUnderTest& robot, int stride = 1) {
    std::vector<Event> events;
    const std::int64_t start_us = robot.clock->now_us();
    for (int i = 1; i <= ticks; ++i) {
      EXPECT_EQ(robot.clock->wait_until(start_us + i * tick_us), PortStatus::ok) << "tick " << i;
      if (i % stride == 0) robot.events->read_until(robot.clock->now_us(), events);
    }
    return events;
  }

 private:
  static void skip_headless() { GTEST_SKIP() << "this backend has no head"; }
};

TEST_P(PortConformance, TheClockReachesEveryRequestedTimeAndNeverGoesBack) {
  const RobotUnderTest robot = make();
  std::int64_t last_us = robot.clock->now_us();
  for (const std::int64_t step_us : {1000, 1, 7000, 1000, 20000}) {
    const std::int64_t target_us = last_us + step_us;
    EXPECT_EQ(robot.clock->wait_until(target_us), PortStatus::ok);
    EXPECT_GE(robot.clock->now_us(), target_us);
    last_us = robot.clock->now_us();
    EXPECT_EQ(robot.clock->wait_until(target_us - 1000), PortStatus::ok) << "a time that has passed";
    EXPECT_GE(robot.clock->now_us(), last_us);
    last_us = robot.clock->now_us();
  }
}

TEST_P(PortConformance, EventsAreSortedInsideTheImageAndNeverFromTheFuture) {
  const RobotUnderTest robot = make();
  const ImageSize size = robot.events->image_size();
  const std::int64_t start_us = robot.clock->now_us();
  std::int64_t last_us = std::numeric_limits<std::int64_t>::min();
  std::size_t count = 0;
  std::vector<Event> events;
  for (int i = 1; i <= ticks; ++i) {
    const std::int64_t previous_us = robot.clock->now_us();
    ASSERT_EQ(robot.clock->wait_until(start_us + i * tick_us), PortStatus::ok);
    events.clear();
    robot.events->read_until(robot.clock->now_us(), events);
    for (const Event& event : events) {
      ASSERT_LE(event.t_us, robot.clock->now_us());
      ASSERT_GE(event.t_us, last_us);
      if (i > 1) {
        ASSERT_GT(event.t_us, previous_us - GetParam().lateness_us);
      }
      ASSERT_TRUE(size.contains(event.x, event.y)) << event.x << ", " << event.y;
      last_us = event.t_us;
    }
    count += events.size();
  }
  EXPECT_GT(count, 0u) << "no events, so nothing was tested";
}

TEST_P(PortConformance, EachEventIsDeliveredOnceForAnyReadInterval) {
  if (GetParam().is_real_time) GTEST_SKIP() << "no two runs are alike";
  const std::vector<Event> often = run(make(), 1);
  EXPECT_FALSE(often.empty());
  EXPECT_EQ(run(make(), 5), often);
  EXPECT_EQ(run(make(), ticks), often);
}

TEST_P(PortConformance, AReadReturnsOnlyEventsUpToItsTime) {
  const RobotUnderTest robot = make();
  const std::int64_t start_us = robot.clock->now_us();
  ASSERT_EQ(robot.clock->wait_until(start_us + ticks * tick_us), PortStatus::ok);
  std::vector<Event> first;
  const std::int64_t half_us = start_us + ticks / 2 * tick_us;
  robot.events->read_until(half_us, first);
  for (const Event& event : first) ASSERT_LE(event.t_us, half_us);
  std::vector<Event> all = first;
  robot.events->read_until(robot.clock->now_us(), all);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), all.begin())) << "read_until appends";
  EXPECT_GT(all.size(), first.size());
  const std::size_t count = all.size();
  robot.events->read_until(robot.clock->now_us(), all);
  EXPECT_EQ(all.size(), count) << "a second read at the same time has nothing new";
}

TEST_P(PortConformance, TheHeadsLimitsAreFiniteAndInOrder) {
  const RobotUnderTest robot = make_with_head();
  if (IsSkipped()) return;
  const JointLimits limits = robot.head->limits();
  EXPECT_TRUE(limits.min_rad.allFinite() && limits.max_rad.allFinite());
  ASSERT_NE(limits.head, nullptr);
  for (const HeadJoint& joint : limits.head->joints) {
    EXPECT_LT(limits.min_rad[joint.slot], limits.max_rad[joint.slot]) << joint.name;
    EXPECT_GT(limits.max_speed_rad_s[joint.slot], 0.0) << joint.name;
  }
}

TEST_P(PortConformance, EncodersAreFiniteNeverFromTheFutureAndNeverGoBackInTime) {
  const RobotUnderTest robot = make_with_head();
  if (IsSkipped()) return;
  HeadState last;
  ASSERT_EQ(robot.head->read(last), PortStatus::ok);
  const std::int64_t start_us = robot.clock->now_us();
  ASSERT_LE(last.t_us, start_us);
  for (int i = 1; i <= ticks; ++i) {
    ASSERT_EQ(robot.clock->wait_until(start_us + i * tick_us), PortStatus::ok);
    HeadState state;
    ASSERT_EQ(robot.head->read(state), PortStatus::ok);
    ASSERT_LE(state.t_us, robot.clock->now_us());
    ASSERT_GE(state.t_us, last.t_us);
    ASSERT_TRUE(state.position_rad.allFinite() && state.velocity_rad_s.allFinite());
    last = state;
  }
  EXPECT_GT(last.t_us, start_us) << "the encoders are read again and again";
}

TEST_P(PortConformance, ReferencesInsideTheLimitsAreAccepted) {
  if (!GetParam().accepts_commands) GTEST_SKIP() << "another controller has the joints";
  const RobotUnderTest robot = make_with_head();
  if (IsSkipped()) return;
  for (const double share : {0.0, 0.5, 1.0, -1.0}) {
    const auto result = robot.head->command(inside_limits(*robot.head, share));
    EXPECT_EQ(result.status, PortStatus::ok);
    EXPECT_FALSE(result.rejected) << share;
  }
}

TEST_P(PortConformance, AReferenceOutsideTheLimitsOrNotFiniteIsRejectedAndTheLastOneHolds) {
  const RobotUnderTest robot = make_with_head();
  if (IsSkipped()) return;
  const HeadCommand good = inside_limits(*robot.head, 0.3);
  HeadState before;
  robot.head->read(before);
  robot.head->command(good);
  for (int joint = 0; joint < head_joint_count; ++joint) {
    const double beyond = inside_limits(*robot.head, 1.01)[joint];
    for (const double bad : {beyond, std::nan(""), std::numeric_limits<double>::infinity()}) {
      HeadCommand command = inside_limits(*robot.head, -0.3);
      command[joint] = bad;
      const auto result = robot.head->command(command);
      EXPECT_EQ(result.status, PortStatus::ok);
      EXPECT_TRUE(result.rejected) << "joint " << joint << " at " << bad;
    }
  }
  const std::int64_t wait_us = 100 * tick_us;
  robot.clock->wait_until(robot.clock->now_us() + wait_us);
  HeadState state;
  robot.head->read(state);
  if (GetParam().is_real_time) {
    if (!GetParam().moves_as_commanded) return;
    const double way = (good - before.head_position_rad()).norm();
    EXPECT_LT((good - state.head_position_rad()).norm(), way) << "it is on its way to the one that was taken";
    return;
  }
  const RobotUnderTest twin = make();
  twin.head->command(good);
  twin.clock->wait_until(twin.clock->now_us() + wait_us);
  HeadState twin_state;
  twin.head->read(twin_state);
  EXPECT_EQ(state.t_us, twin_state.t_us);
  EXPECT_EQ(state.position_rad, twin_state.position_rad);
}

TEST_P(PortConformance, ACommandedHeadFollowsAndARecordedHeadReplaysItsMotion) {
  if (!GetParam().accepts_commands) GTEST_SKIP() << "another controller has the joints";
  const RobotUnderTest robot = make_with_head();
  if (IsSkipped()) return;
  HeadState before;
  robot.head->read(before);
  const HeadCommand towards = inside_limits(*robot.head, 0.1);
  const HeadCommand reference = before.head_position_rad() + 0.2 * (towards - before.head_position_rad());
  ASSERT_FALSE(robot.head->command(reference).rejected);
  robot.clock->wait_until(robot.clock->now_us() + ticks * tick_us);
  HeadState after;
  robot.head->read(after);
  if (!GetParam().moves_as_commanded) {
    const RobotUnderTest twin = make();
    twin.clock->wait_until(twin.clock->now_us() + ticks * tick_us);
    HeadState twin_after;
    twin.head->read(twin_after);
    EXPECT_EQ(after.position_rad, twin_after.position_rad);
    return;
  }
  // Within 0.3 s a servo has done at least half of a small step (a lag below 0.4 s).
  for (int joint = 0; joint < head_joint_count; ++joint) {
    const double step = reference[joint] - before.head_position_rad()[joint];
    const double left = reference[joint] - after.head_position_rad()[joint];
    if (std::abs(step) > 1e-3) {
      EXPECT_LT(std::abs(left), 0.5 * std::abs(step)) << "joint " << joint;
    }
  }
}

TEST_P(PortConformance, AStoppedHeadRestsWithinATenthOfASecondBeforeItsReference) {
  if (!GetParam().moves_as_commanded) GTEST_SKIP() << "a recorded head moves as it did";
  const RobotUnderTest robot = make_with_head();
  if (IsSkipped()) return;
  HeadState before;
  robot.head->read(before);
  const HeadCommand way = inside_limits(*robot.head, 0.8) - before.head_position_rad();
  ASSERT_FALSE(robot.head->command(before.head_position_rad() + way).rejected);
  const std::int64_t start_us = robot.clock->now_us();
  robot.clock->wait_until(start_us + 20 * tick_us);
  EXPECT_EQ(robot.head->stop(), PortStatus::ok);
  EXPECT_EQ(robot.head->stop(), PortStatus::ok) << "a second time";
  robot.clock->wait_until(start_us + 120 * tick_us);
  HeadState stopped;
  robot.head->read(stopped);
  robot.clock->wait_until(start_us + 220 * tick_us);
  HeadState later;
  robot.head->read(later);
  for (int joint = 0; joint < head_joint_count; ++joint) {
    const double left =
        std::abs(before.head_position_rad()[joint] + way[joint] - later.head_position_rad()[joint]);
    const double drift = std::abs(later.head_position_rad()[joint] - stopped.head_position_rad()[joint]);
    EXPECT_LT(drift, 0.05 * std::abs(way[joint]) + 1e-3) << "joint " << joint;
    if (!GetParam().moves_instantly && std::abs(way[joint]) > 0.05) {
      EXPECT_GT(left, 0.2 * std::abs(way[joint])) << "joint " << joint;
    }
  }
}

TEST_P(PortConformance, TheLastPacketOfTheCameraIsNeverInTheFuture) {
  const RobotUnderTest robot = make();
  const std::int64_t start_us = robot.clock->now_us();
  run(robot);
  EXPECT_LE(robot.events->heard_us(), robot.clock->now_us());
  EXPECT_GT(robot.events->heard_us(), start_us);
  EXPECT_EQ(robot.events->traffic().dropped, 0);
}

TEST_P(PortConformance, TheEndComesAfterTheLastEventAndIsPermanent) {
  if (!GetParam().ends) GTEST_SKIP() << "this backend does not end";
  const RobotUnderTest robot = make();
  std::vector<Event> events;
  PortStatus status = PortStatus::ok;
  bool source_ended = false;
  for (int i = 0; i < 60000 && status == PortStatus::ok; ++i) {
    status = robot.clock->wait_until(robot.clock->now_us() + tick_us);
    if (status != PortStatus::ok) break;
    const std::size_t before = events.size();
    const PortStatus read = robot.events->read_until(robot.clock->now_us(), events);
    EXPECT_TRUE(!source_ended || events.size() == before);
    source_ended = source_ended || read == PortStatus::ended;
  }
  EXPECT_EQ(status, PortStatus::ended);
  EXPECT_TRUE(source_ended);

  const RobotUnderTest twin = make();
  std::vector<Event> at_once;
  EXPECT_EQ(twin.clock->wait_until(twin.clock->now_us() + 60'000'000), PortStatus::ok);
  while (twin.clock->wait_until(twin.clock->now_us() + tick_us) == PortStatus::ok) {
    twin.events->read_until(twin.clock->now_us(), at_once);
  }
  EXPECT_EQ(events, at_once) << "no event is missed, whatever the tick";

  const std::int64_t end_us = robot.clock->now_us();
  const std::size_t count = events.size();
  EXPECT_EQ(robot.clock->wait_until(end_us), PortStatus::ended);
  EXPECT_EQ(robot.clock->wait_until(end_us + tick_us), PortStatus::ended);
  EXPECT_EQ(robot.events->read_until(end_us, events), PortStatus::ended);
  EXPECT_EQ(events.size(), count);
  if (robot.head == nullptr) return;
  HeadState state;
  state.t_us = 42;
  EXPECT_EQ(robot.head->read(state), PortStatus::ended);
  EXPECT_EQ(state.t_us, 42) << "the state is left as it was";
  EXPECT_EQ(robot.head->command(inside_limits(*robot.head, 0.0)).status, PortStatus::ended);
}

}  // namespace saccade
