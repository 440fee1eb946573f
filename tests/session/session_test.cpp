#include "session/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.h"
#include "head/icub_cameras.h"
#include "recording/format_registry.h"
#include "robot/fake/fake_robot.h"
#include "session/log_file.h"
#include "session/recorded_scores.h"
#include "session/run_folder.h"
#include "tests/control/genova02.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Keeps the times of the ticks.
class TickTimes final : public LoopObserver {
 public:
  explicit TickTimes(std::vector<std::string>& calls, std::string name = {})
      : calls_(calls), name_(std::move(name)) {}
  void on_tick(const Tick& tick) override { calls_.push_back(name_ + std::to_string(tick.t_us)); }

 private:
  std::vector<std::string>& calls_;
  std::string name_;
};

/// Reports a circle that moves with time, at scores of 0 to 9.
class ScriptedDetector final : public Detector {
 public:
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t now_us, const CameraMotion*) override { now_us_ = now_us; }
  [[nodiscard]] Estimate estimate() override {
    const auto tick = static_cast<double>(now_us_ / 1000);
    return {now_us_ / 1000 % 7 != 0,
            true,
            {60.0 + tick * 0.01, 64.0, 20.0},
            static_cast<double>(now_us_ / 1000 % 10)};
  }
  [[nodiscard]] double threshold() const override { return 5.0; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  std::int64_t now_us_ = 0;
};

FakeRobotScript world() {
  FakeRobotScript script;
  script.limits = genova02_limits();
  return script;
}

Loop loop_on(Robot& robot, bool with_detector = false) {
  std::vector<LoopDetector> detectors;
  if (with_detector) detectors.push_back({"scripted", std::make_unique<ScriptedDetector>()});
  return {robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::nullopt};
}

TEST(Session, TicksUpToItsEndAndCallsObserversInTheirOrder) {
  FakeRobot robot(world());
  Loop loop = loop_on(robot);
  std::vector<std::string> calls;
  TickTimes first(calls, "a"), second(calls, "b");
  Session session(robot, loop);
  session.add_observer(first);
  session.add_observer(second);
  EXPECT_EQ(session.wall_s(), 0.0);
  session.run(1000, 2999);
  EXPECT_THAT(calls, ElementsAre("a1000", "b1000", "a2000", "b2000"));
  EXPECT_GT(session.wall_s(), 0.0);
}

TEST(Session, EndsWithTheDataOfTheRobot) {
  FakeRobotScript script = world();
  script.end_us = 3000;
  FakeRobot robot(script);
  Loop loop = loop_on(robot);
  std::vector<std::string> calls;
  TickTimes times(calls);
  Session session(robot, loop);
  session.add_observer(times);
  session.run(1000);
  EXPECT_THAT(calls, ElementsAre("1000", "2000", "3000"));
}

TEST(Session, ALostConnectionFailsTheRunAndIsNamed) {
  FakeRobotScript script = world();
  script.lost_us = 5000;
  FakeRobot robot(script);
  Loop loop = loop_on(robot);
  Session session(robot, loop);
  EXPECT_THAT([&] { session.run(1000); },
              testing::ThrowsMessage<RunError>(HasSubstr("lost the connection to the clock")));
  EXPECT_EQ(robot.now_us(), 4000);
}

TEST(RecordedScores, AreThoseOfAllRowsAtOnce) {
  std::vector<TruthRow> truth;
  for (std::int64_t t_us = 500; t_us <= 200'500; t_us += 500) {
    truth.push_back(
        {t_us, {60.5 + 1e-5 * static_cast<double>(t_us), 64.0, 20.5}, t_us % 3000 == 0 ? 0.2 : 1.0});
  }
  for (const Chances chances : {Chances::simulated, Chances::annotated}) {
    TempFolder folder;
    FakeRobot robot(world());
    Loop loop = loop_on(robot, true);
    Observations observations(loop);
    RecordedScores scores(loop, observations, truth, chances, folder / "detections.csv");
    Session session(robot, loop);
    session.add_observer(observations);
    session.add_observer(scores);
    session.run(1000, 150'000);
    const DetectorScore found = scores.finish().at(0);
    const auto rows = read_table<DetectionRow>(folder / "detections.csv");
    EXPECT_GT(rows.size(), 100u);
    const DetectorScore expected = score_detector(truth, rows, "scripted", 5.0, chances);
    EXPECT_EQ(found.average_precision, expected.average_precision);
    EXPECT_EQ(found.chances, expected.chances);
    EXPECT_EQ(found.observations, expected.observations);
    EXPECT_EQ(found.inliers, expected.inliers);
    EXPECT_EQ(found.lag_ms, expected.lag_ms);
    EXPECT_EQ(found.mean_rate_hz, expected.mean_rate_hz);
    EXPECT_EQ(found.position_error_px.median, expected.position_error_px.median);
  }
}

TEST(RecordedScores, LeaveOutTheTruthThatAnInterruptedRunDidNotReach) {
  std::vector<TruthRow> truth;
  for (std::int64_t t_us = 1000; t_us <= 200'000; t_us += 1000)
    truth.push_back({t_us, {60.5 + 1e-5 * static_cast<double>(t_us), 64.0, 20.5}, 1.0});
  const auto score_of = [&](std::span<const TruthRow> rows, bool interrupted) {
    FakeRobot robot(world());
    Loop loop = loop_on(robot, true);
    Observations observations(loop);
    RecordedScores scores(loop, observations, rows, Chances::simulated, {});
    Session session(robot, loop);
    session.add_observer(observations);
    session.add_observer(scores);
    session.run(1000, 50'000);
    if (interrupted) scores.leave_out_truth_after(robot.now_us());
    EXPECT_EQ(scores.truth().size(), interrupted ? 50u : rows.size());
    return scores.finish().at(0);
  };
  const DetectorScore interrupted = score_of(truth, true);
  const DetectorScore short_recording = score_of(std::span(truth).first(50), false);
  EXPECT_EQ(interrupted.chances, 50);
  EXPECT_EQ(interrupted.average_precision, short_recording.average_precision);
  EXPECT_EQ(interrupted.recall, short_recording.recall);
  EXPECT_EQ(score_of(truth, false).chances, 200) << "a recording that ends misses the rest";
}

/// Two runs that start in one folder at once mix their files.
TEST(RunFolder, BelongsToOneRunUntilItsEnd) {
  TempFolder folder;
  const FormatRegistry formats = built_in_formats();
  const auto start = [&] {
    return start_run_folder(folder / "run", true, formats, "scenario.yaml", "name: a\n");
  };
  {
    const auto first = start();
    EXPECT_THAT([&] { static_cast<void>(start()); },
                testing::ThrowsMessage<InputError>(HasSubstr("a run at work in it")));
    EXPECT_EQ(bytes_of(folder / "run/scenario.yaml"), "name: a\n");
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "run/lock"));
  const auto second = start();
  EXPECT_TRUE(std::filesystem::exists(folder / "run/lock"));
}

TEST(RunFolder, ThatAKilledRunLeftCanBeUsedAgain) {
  TempFolder folder;
  const FormatRegistry formats = built_in_formats();
  std::filesystem::create_directories(folder / "run");
  folder.write("run/lock", "");
  EXPECT_NO_THROW(static_cast<void>(prepare_run_folder(folder / "run", false, formats)));
  folder.write("run/lock", "");
  folder.write("run/truth.csv.part", "");
  EXPECT_THROW(static_cast<void>(prepare_run_folder(folder / "run", false, formats)), InputError);
  EXPECT_NO_THROW(static_cast<void>(prepare_run_folder(folder / "run", true, formats)));
  folder.write("run/notes.txt", "");
  EXPECT_THROW(static_cast<void>(prepare_run_folder(folder / "run", true, formats)), InputError);
}

TEST(LogFile, WritesEachLineToTheFileAndToTheEcho) {
  TempFolder folder;
  std::string echoed;
  LogFile log(folder / "log.txt", [&](const std::string& line) { echoed += line + "\n"; });
  log.write(1'500'000, "ball found");
  log.write(12'000'000, "ball lost");
  EXPECT_FALSE(std::filesystem::exists(folder / "log.txt"));
  log.commit();
  EXPECT_EQ(bytes_of(folder / "log.txt"), "     1.500 s  ball found\n    12.000 s  ball lost\n");
  EXPECT_EQ(echoed, bytes_of(folder / "log.txt"));
}

}  // namespace
}  // namespace saccade
