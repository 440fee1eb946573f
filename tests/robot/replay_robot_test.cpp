#include "robot/replay/replay_robot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "tests/recording/temp_folder.h"
#include "tests/robot/scripted_world.h"

namespace saccade {
namespace {

/// Events out of memory: a recording with everything that files can have.
class ListReader final : public EventReader {
 public:
  explicit ListReader(std::vector<Event> events, bool broken_at_end = false)
      : events_(std::move(events)), broken_at_end_(broken_at_end) {}

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    const std::size_t count = std::min(max_events, events_.size() - next_);
    if (count == 0 && broken_at_end_) throw InputError("list: event 3", "a broken event", "a whole one");
    for (std::size_t i = 0; i < count; ++i) events.push_back(events_[next_++]);
    return count;
  }
  std::optional<ImageSize> image_size() const override { return ImageSize{10, 10}; }
  std::string format() const override { return "list"; }

 private:
  std::vector<Event> events_;
  bool broken_at_end_;
  std::size_t next_ = 0;
};

Event event_at(std::int64_t t_us, std::uint16_t x = 0) { return {t_us, x, 0, true, 0}; }

std::vector<std::int64_t> stamps(const std::vector<Event>& events) {
  std::vector<std::int64_t> t_us;
  for (const Event& event : events) t_us.push_back(event.t_us);
  return t_us;
}

constexpr const char* joints_header =
    "t_us,torso_pitch_rad,torso_roll_rad,torso_yaw_rad,neck_pitch_rad,neck_roll_rad,neck_yaw_rad,"
    "eyes_tilt_rad,eyes_version_rad,eyes_vergence_rad\n";

RecordedHead recorded_head(const TempFolder& folder, const std::string& rows) {
  const auto path = folder.write("joints.csv", joints_header + rows);
  return {TableReader<JointsRow>(path), unit_limits()};
}

TEST(ReplayRobot, StartsItsClockAtTheFirstEvent) {
  ReplayRobot robot(std::make_unique<ListReader>(std::vector{event_at(700), event_at(900)}));
  EXPECT_EQ(robot.now_us(), 700);
  EXPECT_EQ(robot.image_size(), (ImageSize{10, 10}));
  EXPECT_EQ(robot.head(), nullptr);
  std::vector<Event> events;
  EXPECT_EQ(robot.read_until(700, events), PortStatus::ok);
  EXPECT_THAT(stamps(events), testing::ElementsAre(700));
}

TEST(ReplayRobot, CountsEventsThatGoBackInTimeOrLieOutsideTheImageAndLeavesThemOut) {
  ReplayRobot robot(std::make_unique<ListReader>(std::vector{
      event_at(5), event_at(7), event_at(6), event_at(7), event_at(8, 10), event_at(2), event_at(9)}));
  std::vector<Event> events;
  robot.wait_until(100);
  EXPECT_EQ(robot.read_until(100, events), PortStatus::ended);
  EXPECT_THAT(stamps(events), testing::ElementsAre(5, 7, 7, 9));
  EXPECT_EQ(robot.rejected().back_in_time, 2);
  EXPECT_EQ(robot.rejected().outside_image, 1);
}

TEST(ReplayRobot, EndsAtOnceWithoutEvents) {
  ReplayRobot robot(std::make_unique<ListReader>(std::vector<Event>{}));
  std::vector<Event> events;
  EXPECT_EQ(robot.read_until(robot.now_us(), events), PortStatus::ended);
  EXPECT_EQ(robot.wait_until(robot.now_us() + 1), PortStatus::ended);
}

TEST(ReplayRobot, DeliversTheEventsBeforeABrokenPlaceAndThenThrows) {
  ReplayRobot robot(std::make_unique<ListReader>(std::vector{event_at(1), event_at(2), event_at(3)}, true));
  std::vector<Event> events;
  robot.wait_until(10);
  EXPECT_THROW(robot.read_until(10, events), InputError);
  EXPECT_THAT(stamps(events), testing::ElementsAre(1, 2, 3));
  EXPECT_THROW(robot.wait_until(11), InputError);
}

TEST(ReplayRobot, RefusesAGapOfMoreThanADayAfterTheEventsBeforeIt) {
  constexpr std::int64_t day_us = 86'400'000'000;
  ReplayRobot robot(
      std::make_unique<ListReader>(std::vector{event_at(5), event_at(5 + day_us), event_at(6 + 2 * day_us)}));
  std::vector<Event> events;
  EXPECT_EQ(robot.wait_until(1000), PortStatus::ok);
  robot.read_until(1000, events);
  EXPECT_EQ(robot.wait_until(5 + day_us), PortStatus::ok) << "a day is short enough";
  robot.read_until(5 + day_us, events);
  EXPECT_THAT(stamps(events), testing::ElementsAre(5, 5 + day_us));
  EXPECT_THAT(
      [&] { robot.wait_until(6 + day_us); },
      testing::ThrowsMessage<InputError>(
          "recording: found no events for 86400.000001 s after 86400000005 us, as after a wrong time stamp "
          "or with those of two clocks, expected events at most a day apart; saccade convert --from S "
          "--until S keeps a part"));
}

TEST(ReplayRobot, WithoutAnImageSizeNamesTheFileAndTheOption) {
  TempFolder folder;
  const auto path = folder.write("a.csv", "1,2,3,1\n");
  EXPECT_THAT([&] { ReplayRobot robot(open_event_file(path)); },
              testing::ThrowsMessage<InputError>(
                  path.string() + ": found text without an image size, expected --size WIDTHxHEIGHT"));
}

TEST(ReplayRobot, WithJointsStartsAtTheirFirstRowAndEndsAfterTheirLast) {
  TempFolder folder;
  ReplayRobot robot(std::make_unique<ListReader>(std::vector{event_at(500), event_at(1000), event_at(1500)}),
                    recorded_head(folder, "1000,0,0,0,0,0,0,0,0,0\n3000,0,0,0,0,0,0,0,0,0\n"));
  EXPECT_EQ(robot.now_us(), 1000);
  std::vector<Event> events;
  EXPECT_EQ(robot.wait_until(2000), PortStatus::ok);
  EXPECT_EQ(robot.read_until(2000, events), PortStatus::ok) << "the head goes on";
  EXPECT_THAT(stamps(events), testing::ElementsAre(1000, 1500));
  EXPECT_EQ(robot.events_before_start(), 1);
  EXPECT_EQ(robot.rejected().back_in_time, 0) << "an event before the joints does not go back in time";
  EXPECT_EQ(robot.wait_until(3000), PortStatus::ok);
  EXPECT_EQ(robot.read_until(3000, events), PortStatus::ended);
  EXPECT_EQ(robot.wait_until(3001), PortStatus::ended);
}

TEST(ReplayRobot, HeadReturnsTheNewestRowAndTheVelocityBetweenTheLastTwo) {
  TempFolder folder;
  ReplayRobot robot(std::make_unique<ListReader>(std::vector{event_at(0), event_at(9000)}),
                    recorded_head(folder,
                                  "0,0,0,0,0.1,0,0,0,0,0\n2000,0,0,0,0.1,0,0,0,0,0\n"
                                  "4000,0,0,0,0.3,0,0,0,0,-0.2\n8000,0,0,0,0.3,0,0,0,0,-0.2\n"));
  HeadState state;
  robot.head()->read(state);
  EXPECT_EQ(state.t_us, 0);
  EXPECT_EQ(state.position_rad[neck_pitch], 0.1);
  EXPECT_TRUE(state.velocity_rad_s.isZero());
  robot.wait_until(3999);
  robot.head()->read(state);
  EXPECT_EQ(state.t_us, 2000);
  EXPECT_TRUE(state.velocity_rad_s.isZero());
  robot.wait_until(5000);
  robot.head()->read(state);
  EXPECT_EQ(state.t_us, 4000);
  EXPECT_EQ(state.position_rad[eyes_vergence], -0.2);
  EXPECT_NEAR(state.velocity_rad_s[neck_pitch], 100.0, 1e-9);
  EXPECT_NEAR(state.velocity_rad_s[eyes_vergence], -100.0, 1e-9);
}

TEST(ReplayRobot, RejectsAJointTableWithoutRows) {
  TempFolder folder;
  EXPECT_THROW(ReplayRobot(std::make_unique<ListReader>(std::vector{event_at(1)}), recorded_head(folder, "")),
               InputError);
}

TEST(ReplayRobot, ReplaysEveryEventOfTheLoomingBall) {
  const std::filesystem::path path =
      std::filesystem::path(SACCADE_SHARED_DATA) / "ball_looming_dvs128_aedat2.aedat";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "SKIPPED: the real recordings are absent: " << path;
  ReplayRobot robot(open_event_file(path));
  EXPECT_EQ(robot.now_us(), 913454806);
  std::vector<Event> events;
  std::int64_t count = 0;
  while (robot.wait_until(robot.now_us() + 1000) == PortStatus::ok) {
    events.clear();
    robot.read_until(robot.now_us(), events);
    count += static_cast<std::int64_t>(events.size());
  }
  EXPECT_EQ(count + robot.rejected().back_in_time + robot.rejected().outside_image, 314716);
  EXPECT_EQ(robot.rejected().outside_image, 0);
  RecordProperty("back_in_time", std::to_string(robot.rejected().back_in_time));
  EXPECT_LT(robot.rejected().back_in_time, 10);
}

TEST(ReplayRobot, WithImuRowsOffersTheNewestReadingAtEachTime) {
  TempFolder folder;
  const auto joints = folder.write(
      "joints.csv", std::string(joints_header) + "1000,0,0,0,0,0,0,0,0,0\n9000,0,0,0,0,0,0,0,0,0\n");
  {
    TableWriter<ImuRow> imu(joints.parent_path() / "imu.csv");
    imu.write({1000, {900, {0.1, 0.0, 0.0}, {0.0, 0.0, 9.81}}});
    imu.write({3000, {2900, {0.2, 0.0, -1.5}, {0.25, 0.0, 9.5}}});
    imu.commit();
  }
  ReplayRobot robot(
      std::make_unique<ListReader>(std::vector{event_at(2000)}),
      RecordedHead{TableReader<JointsRow>(joints), unit_limits(), recorded_imu(joints.parent_path())});
  ASSERT_NE(robot.imu(), nullptr);
  ImuReading reading;
  EXPECT_EQ(robot.imu()->read_imu(reading), PortStatus::ok);
  EXPECT_EQ(reading.t_us, 900);
  robot.wait_until(2999);
  robot.imu()->read_imu(reading);
  EXPECT_EQ(reading.angular_velocity_rad_s.x(), 0.1);
  robot.wait_until(3000);
  robot.imu()->read_imu(reading);
  EXPECT_EQ(reading.t_us, 2900);
  EXPECT_EQ(reading.angular_velocity_rad_s, Eigen::Vector3d(0.2, 0.0, -1.5));
  EXPECT_EQ(reading.acceleration_m_s2, Eigen::Vector3d(0.25, 0.0, 9.5));
  robot.wait_until(9000);
  std::vector<Event> events;
  EXPECT_EQ(robot.read_until(9000, events), PortStatus::ended);
  robot.wait_until(9001);
  EXPECT_EQ(robot.imu()->read_imu(reading), PortStatus::ended);
}

TEST(ReplayRobot, WithoutImuRowsHasNoInertialSensor) {
  TempFolder folder;
  ReplayRobot robot(std::make_unique<ListReader>(std::vector{event_at(500)}),
                    recorded_head(folder, "400,0,0,0,0,0,0,0,0,0\n"));
  EXPECT_EQ(robot.imu(), nullptr);
}

}  // namespace
}  // namespace saccade
