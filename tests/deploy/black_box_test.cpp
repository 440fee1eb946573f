#include "apps/deploy/black_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

Tick tick_at(std::int64_t t_us) {
  Tick tick;
  tick.t_us = t_us;
  tick.head.emplace();
  tick.head->t_us = t_us;
  tick.head->position_rad[neck_yaw] = 0.25;
  tick.command.reference_rad.setConstant(0.125);
  return tick;
}

TEST(BlackBox, HoldsTheLastTenSecondsAfterAnyNumberOfTurns) {
  const TempFolder folder;
  BlackBox box(folder / "blackbox");
  TickTiming timing;
  timing.state = DeployState::active;
  const std::vector<Event> events = {{5, 1, 2, true, 0}};
  for (std::int64_t t_us = 0; t_us <= 34'000'000; t_us += 10'000) box.add(tick_at(t_us), timing, {}, events);
  box.add(34'000'000, "stopped: by the operator");
  box.flush();
  EXPECT_EQ(box.failure(), "");
  const std::string older = text_of(folder / "blackbox/ticks_0.csv");
  const std::string newer = text_of(folder / "blackbox/ticks_1.csv");
  EXPECT_THAT(older, StartsWith("t_us,due_us"));
  EXPECT_THAT(older + newer, HasSubstr("\n24000000,"));
  EXPECT_THAT(older + newer, HasSubstr("\n34000000,"));
  EXPECT_EQ((older + newer).find("\n9990000,"), std::string::npos) << "and not much more";
  EXPECT_THAT(text_of(folder / "blackbox/messages_1.txt"), HasSubstr("34.000 s  stopped: by the operator"));
  EXPECT_THAT(text_of(folder / "blackbox/events_1.csv"), HasSubstr("\n5,1,2,1,0\n"));
}

TEST(BlackBox, EveryRowHasTheColumnsOfTheFirstLine) {
  const TempFolder folder;
  BlackBox box(folder / "blackbox");
  TickTiming timing;
  Tick bare;
  bare.t_us = 1000;
  box.add(bare, timing, {}, {});
  timing.state = DeployState::active;
  Tick full = tick_at(2000);
  full.target_m = Eigen::Vector3d(-0.5, 0.0, 0.3);
  std::vector<DetectorTick> detectors(1);
  detectors[0].estimate = {true, true, {64, 60, 10}, 0.75};
  detectors[0].observed = true;
  box.add(full, timing, detectors, {});
  box.flush();
  std::istringstream lines(text_of(folder / "blackbox/ticks_0.csv"));
  std::string line;
  std::getline(lines, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  for (; std::getline(lines, line); ++rows)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns) << line;
  EXPECT_EQ(rows, 2);
}

TEST(BlackBox, IsInTheFileSystemWithoutAnEndOfTheProgram) {
  const TempFolder folder;
  BlackBox box(folder / "blackbox");
  box.add(tick_at(1000), {}, {}, {});
  box.flush();
  EXPECT_THAT(text_of(folder / "blackbox/ticks_0.csv"), HasSubstr("\n1000,")) << "before its destructor";
}

}  // namespace
}  // namespace saccade
