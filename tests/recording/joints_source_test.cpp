#include "recording/joints_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "core/error.h"
#include "recording/event_file.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double deg = std::numbers::pi / 180.0;

std::vector<JointsRow> all_of(JointsSource source) {
  std::vector<JointsRow> rows;
  while (std::optional<JointsRow> row = source.next()) rows.push_back(*row);
  return rows;
}

std::vector<std::int64_t> times_of(JointsSource source) {
  std::vector<std::int64_t> times;
  for (const JointsRow& row : all_of(std::move(source))) times.push_back(row.t_us);
  return times;
}

/// A source with rows at these times.
JointsSource rows_at(std::vector<std::int64_t> t_us) {
  return JointsSource([t_us, i = std::size_t{0}]() mutable -> std::optional<JointsRow> {
    if (i == t_us.size()) return std::nullopt;
    return JointsRow{.t_us = t_us[i++]};
  });
}

TEST(HeadLog, HoldsTheHeadsJointsInDegreesAndOneTimeOrTwo) {
  const TempFolder folder;
  const auto path = folder.write("data.log",
                                 "0 1571751370.660680 -3.5 1 20 -10 5.25 8\n\n"
                                 "1 1571751370.680680 1571751370.680700\t-3 1 20 -10 5.25 8 \r\n");
  EXPECT_TRUE(is_head_log(path));
  const std::vector<JointsRow> rows = all_of(open_head_log(path, 0));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].t_us, 1571751370660680);
  EXPECT_EQ(rows[1].t_us, 1571751370680700) << "of two times the last one, the receiver's";
  JointVector expected = JointVector::Zero();
  expected << 0, 0, 0, -3.5 * deg, 1 * deg, 20 * deg, -10 * deg, 5.25 * deg, 8 * deg;
  EXPECT_TRUE(rows[0].position_rad.isApprox(expected, 1e-15));
  EXPECT_EQ(all_of(open_head_log(path, 1571751370000000)).at(0).t_us, 660680);
}

TEST(HeadLog, ErrorsNameFileLineAndContent) {
  const TempFolder folder;
  for (const char* line : {"1 2.0 1 2 3 4 5", "1 2.0 2.0 2.0 1 2 3 4 5 6", "1 x 1 2 3 4 5 6",
                           "a 2.0 1 2 3 4 5 6", "1 2.0 1 2 3 4 5 nan", "1 2.0 (1 2 3 4 5 6)"}) {
    const auto path = folder.write("data.log", "0 1.0 1 2 3 4 5 6\n" + std::string(line) + "\n");
    EXPECT_THAT([&] { (void)all_of(open_head_log(path, 0)); },
                testing::ThrowsMessage<InputError>(testing::AllOf(
                    HasSubstr("data.log:2: found " + std::string(line)), HasSubstr("six joints in degrees"))))
        << line;
  }
  const auto back = folder.write("back.log", "0 2.0 1 2 3 4 5 6\n1 1.9 1 2 3 4 5 6\n");
  EXPECT_THAT([&] { (void)all_of(open_head_log(back, 0)); },
              testing::ThrowsMessage<InputError>(HasSubstr("back.log:2: found a time before")));
  EXPECT_THROW((void)is_head_log(folder / "none.log"), InputError);
}

TEST(HeadLog, IsToldFromATableOfJoints) {
  const TempFolder folder;
  TableWriter<JointsRow> table(folder / "joints.csv");
  table.write({1000, JointVector::Constant(0.25)});
  table.commit();
  EXPECT_FALSE(is_head_log(folder / "joints.csv"));
  EXPECT_EQ(all_of(TableReader<JointsRow>(folder / "joints.csv")).at(0).position_rad[neck_yaw], 0.25);
}

TEST(JointsFrom, BeginsWithTheLastRowThatIsNotLater) {
  EXPECT_THAT(times_of(joints_from(rows_at({1, 2, 3, 4}), 2)), ElementsAre(2, 3, 4));
  EXPECT_THAT(times_of(joints_from(rows_at({1, 5, 9}), 7)), ElementsAre(5, 9));
  EXPECT_THAT(times_of(joints_from(rows_at({5, 9}), 2)), ElementsAre(5, 9));
  EXPECT_THAT(times_of(joints_from(rows_at({5, 9}), 20)), ElementsAre(9));
  EXPECT_THAT(times_of(joints_from(rows_at({}), 20)), ElementsAre());
}

TEST(EventFile, OfAnEventDrivenLogSaysHowFarTheHostsClockIsAhead) {
  const TempFolder folder;
  // Ticks of 80 ns: the events are at 8 and 16 us, then at 24 us; the second packet came 3 us faster.
  const auto path = folder.write("data.log", "0 100.000026 AE (100 2 200 4)\n1 100.000031 AE (300 2)\n");
  EventReadOptions left;
  left.camera = std::uint8_t{0};
  const auto reader = open_event_file(path, left);
  EXPECT_EQ(reader->host_ahead_us(), std::nullopt) << "nothing is read yet";
  std::vector<Event> events;
  while (reader->read(events, 1000) > 0) {
  }
  EXPECT_EQ(events.size(), 3U);
  EXPECT_EQ(reader->host_ahead_us(), 100'000'007);
  const auto text = open_event_file(folder.write("events.txt", "10 3 4 1\n20 3 4 0\n"));
  while (text->read(events, 1000) > 0) {
  }
  EXPECT_EQ(text->host_ahead_us(), std::nullopt);
}

}  // namespace
}  // namespace saccade
