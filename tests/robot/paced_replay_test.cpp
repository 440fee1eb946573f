#include "robot/replay/paced_replay.h"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/recording/temp_folder.h"
#include "tests/robot/scripted_world.h"

namespace saccade {
namespace {

TEST(PacedReplay, DeliversTheEventsOfAReplayInRealTime) {
  const FakeRobotScript script = scripted_world();
  TempFolder folder;
  const auto writer = create_event_file(folder / "a.csv", script.image_size);
  writer->write(script.events);
  writer->commit();
  EventReadOptions options;
  options.image_size = script.image_size;
  constexpr double speed = 5.0;
  PacedReplay robot("a.csv", open_event_file(folder / "a.csv", options), std::nullopt, speed);
  EXPECT_EQ(robot.clock().now_us(), script.events.front().t_us) << "time starts with the first wait";
  EXPECT_EQ(robot.head(), nullptr);

  const auto begin = std::chrono::steady_clock::now();
  std::vector<Event> events;
  PortStatus status = PortStatus::ok;
  std::int64_t last_us = robot.now_us();
  for (std::int64_t t_us = last_us + 1000; status == PortStatus::ok; t_us += 1000) {
    status = robot.wait_until(t_us);
    if (status != PortStatus::ok) break;
    const std::int64_t now_us = robot.now_us();
    ASSERT_GE(now_us, t_us);
    ASSERT_GE(now_us, last_us);
    last_us = now_us;
    robot.events().read_until(t_us, events);
    ASSERT_TRUE(events.empty() || events.back().t_us <= t_us);
  }
  EXPECT_EQ(status, PortStatus::ended);
  EXPECT_EQ(events, script.events);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const double recorded_s =
      1e-6 * static_cast<double>(script.events.back().t_us - script.events.front().t_us);
  EXPECT_GE(took.count(), recorded_s / speed);
}

}  // namespace
}  // namespace saccade
