#include "apps/deploy/recording_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/deploy/deploy_recorder.h"
#include "core/error.h"
#include "evaluation/report/report.h"
#include "head/icub_cameras.h"
#include "recording/format_registry.h"
#include "recording/recorded_folder.h"
#include "tests/deploy/fake_deployed.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

std::vector<Event> events_of(const std::filesystem::path& file) {
  std::vector<Event> events;
  const auto reader = open_event_file(file);
  while (reader->read(events, 1 << 16) > 0) {
  }
  return events;
}

/// Writes 1000 events per second and a reading every 10 ms, from second `from` to second `to`.
void write(RecordingFiles& files, int from, int to) {
  for (std::int64_t t_us = from * 1'000'000; t_us < to * 1'000'000; t_us += 1000) {
    const std::vector<Event> events = {{t_us, 3, 4, t_us % 2000 == 0, 0}};
    std::optional<JointsRow> joints;
    if (t_us % 10'000 == 0) joints = JointsRow{t_us, JointVector::Zero()};
    files.write(t_us, events, joints);
  }
}

TEST(RecordingFiles, GoOnInTheNextPairAfterTheirTimeAndLoseNoEvent) {
  const TempFolder folder;
  RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {"aedat4", INT64_MAX, 3'000'000, 0});
  write(files, 1, 9);
  files.commit();
  EXPECT_EQ(files.count(), 3);
  EXPECT_EQ(files.first_file(), "events.aedat4");
  std::vector<Event> all;
  for (const char* name : {"events.aedat4", "events_2.aedat4", "events_3.aedat4"}) {
    const auto part = events_of(folder / name);
    all.insert(all.end(), part.begin(), part.end());
  }
  ASSERT_EQ(all.size(), 8000u);
  for (std::size_t i = 0; i < all.size(); ++i)
    ASSERT_EQ(all[i].t_us, 1'000'000 + static_cast<std::int64_t>(i) * 1000);
  EXPECT_EQ(read_table<JointsRow>(folder / "joints_2.csv").size(), 300u);
}

TEST(RecordingFiles, GoOnInTheNextPairAfterTheirSize) {
  const TempFolder folder;
  RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {"csv", 30'000, INT64_MAX, 0});
  write(files, 1, 9);
  files.commit();
  EXPECT_GE(files.count(), 3);
}

TEST(RecordingFiles, NumbersGoOnAfterThoseThatAreThereFinishedOrNot) {
  const TempFolder folder;
  const auto record = [&] {
    RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {"csv", INT64_MAX, INT64_MAX, 0});
    write(files, 1, 2);
    files.commit();
    return files.first_file();
  };
  EXPECT_EQ(record(), "events.csv");
  EXPECT_EQ(record(), "events_2.csv");
  std::ofstream(folder / "events_7.csv.part") << "of a killed run";
  EXPECT_EQ(record(), "events_8.csv");
  EXPECT_EQ(events_of(folder / "events.csv").size(), 1000u) << "the first one is untouched";
}

TEST(RecordingFiles, ADiskWithoutRoomIsRefusedAndEndsARecording) {
  const TempFolder folder;
  const RecordingFilesConfig full{"csv", INT64_MAX, INT64_MAX, INT64_MAX};
  EXPECT_THAT(
      [&] {
        RecordingFiles files(folder / "", built_in_formats(), {128, 128}, full);
      },
      testing::ThrowsMessage<RunError>(HasSubstr("MB free, --record needs output.least_free_mb")));
}

class LiveFormats : public testing::TestWithParam<std::string> {};

TEST_P(LiveFormats, LoseAtMostTheLastSecondOfAPowerCut) {
  const TempFolder folder;
  const std::filesystem::path part = folder / ("events." + GetParam() + ".part");
  std::vector<std::uintmax_t> synced;  // size of the file when second 2, 3 ... begins
  {
    RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {GetParam(), INT64_MAX, INT64_MAX, 0});
    for (int second = 1; second < 5; ++second) {
      write(files, second, second + 1);
      files.write((second + 1) * 1'000'000, {}, std::nullopt);
      synced.push_back(std::filesystem::file_size(part));
    }
  }
  const EventReadOptions options{.image_size = ImageSize{128, 128}};
  for (std::size_t i = synced.size(); i-- > 0;) {
    std::filesystem::resize_file(part, synced[i]);
    const auto file = inspect_recorded(built_in_formats(), part, options).front();
    EXPECT_GE(file.rows, 1000 * static_cast<std::int64_t>(i + 1)) << file.unreadable;
    EXPECT_GE(file.last_us, (static_cast<std::int64_t>(i) + 2) * 1'000'000 - 1000);
  }
  EXPECT_GE(inspect_recorded(built_in_formats(), folder / "joints.csv.part", options).front().rows, 399);
}

INSTANTIATE_TEST_SUITE_P(, LiveFormats,
                         testing::Values("aedat", "aedat4", "bag", "csv", "log", "mcap", "raw"));

/// While it lives no file of this process gets larger than so many bytes, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit full{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &full);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST(RecordingFiles, ADiskThatGetsFullEndsTheRecordingWithItsCauseAndKeepsWhatIsThere) {
  const TempFolder folder;
  RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {"csv", INT64_MAX, INT64_MAX, 0});
  {
    const FullDisk disk(100'000);
    write(files, 1, 20);
    files.commit();
  }
  EXPECT_THAT(files.ended(), HasSubstr("events.csv: cannot be written: File too large: the recording ended"));
  EXPECT_FALSE(std::filesystem::exists(folder / "events.csv")) << "it is not whole";
  const auto file = inspect_recorded(built_in_formats(), folder / "events.csv.part", {}).front();
  EXPECT_GT(file.rows, 5000);
  const auto whole = write_whole_part(built_in_formats(), file, {});
  EXPECT_EQ(events_of(whole).size(), static_cast<std::size_t>(file.rows));
}

TEST(DeployRecorder, TheTablesEndWhereTheDiskHasTooLittleRoomAndTheRunGoesOn) {
  const TempFolder folder;
  FakeRobotScript script;
  script.limits.max_rad.setConstant(1.0);
  FakeDeployed robot(script, false);
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, {}, std::nullopt);
  RobotFile file;
  file.output.least_free_mb = INT64_MAX / 2'000'000;
  DeployRecorder recorder(folder / "", file, loop, {128, 128}, {});
  for (std::int64_t t_us = 1000; t_us <= 3'000'000; t_us += 1000) {
    Tick tick;
    tick.t_us = t_us;
    tick.head.emplace();
    TickTiming timing;
    timing.due_us = timing.begin_us = timing.end_us = t_us;
    recorder.on_tick(tick, timing);
    if (t_us % 1'000'000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  recorder.finish();
  EXPECT_LT(read_table<GazeRow>(folder / "gaze.csv").size(), 10u) << "the first look at the disk";
  const std::string summary = bytes_of(folder / "deploy.json");
  EXPECT_THAT(summary, HasSubstr("\"tables_ended\": true"));
  EXPECT_THAT(summary, HasSubstr("\"count\": 3000")) << "every tick is in the figures";
  EXPECT_THAT(bytes_of(folder / "log.txt"), HasSubstr("MB are free: the tables ended"));
}

/// A detector in a program that ends in the tick at 2 s.
class EndingDetector final : public Detector {
 public:
  void process(std::span<const Event> /*events*/, const CameraMotion* /*motion*/) override {}
  void advance_to(std::int64_t now_us, const CameraMotion* /*motion*/) override { now_us_ = now_us; }
  [[nodiscard]] Estimate estimate() override { return {}; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }
  [[nodiscard]] std::string_view failure() const override {
    return now_us_ >= 2'000'000 ? "program ended at 2 s, with status 3" : "";
  }

 private:
  std::int64_t now_us_ = 0;
};

/// A gaze controller in a program that has ended.
class EndedController final : public GazeController {
 public:
  HeadJointVector step(const HeadState& /*state*/, const std::optional<Eigen::Vector3d>& /*target_m*/,
                       double /*dt_s*/) override {
    return HeadJointVector::Zero();
  }
  void rest() override {}
  [[nodiscard]] TargetStatus target_status() const override { return TargetStatus::none; }
  [[nodiscard]] std::string_view failure() const override { return "program ended, by signal 11"; }
};

TEST(DeployRecorder, ReportsWhatEndedWhenAndWhy) {
  const TempFolder folder;
  FakeRobotScript script;
  script.limits.max_rad.setConstant(1.0);
  FakeDeployed robot(script, false);
  std::vector<LoopDetector> detectors;
  detectors.push_back({"mine", std::make_unique<EndingDetector>()});
  LoopGaze gaze;
  gaze.motion.emplace();
  gaze.motion->controller = std::make_unique<EndedController>();
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::move(gaze));
  const RobotFile file;
  DeployRecorder recorder(folder / "", file, loop, {128, 128}, {});
  for (std::int64_t t_us = 1000; t_us <= 3'000'000; t_us += 1000) {
    loop.detectors()[0].detector->advance_to(t_us, nullptr);
    if (t_us == 2'500'000) loop.clear_motion();  // the head is stopped
    Tick tick;
    tick.t_us = t_us;
    TickTiming timing;
    timing.due_us = timing.begin_us = timing.end_us = t_us;
    recorder.on_tick(tick, timing);
  }
  recorder.finish();
  const auto ended = nlohmann::json::parse(bytes_of(folder / "deploy.json"))["ended"];
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0]["what"], "gaze controller");
  EXPECT_EQ(ended[0]["t_us"], 1000);
  EXPECT_EQ(ended[0]["why"], "program ended, by signal 11");
  EXPECT_EQ(ended[1]["what"], "detector mine");
  EXPECT_EQ(ended[1]["t_us"], 2'000'000);
  EXPECT_EQ(ended[1]["why"], "program ended at 2 s, with status 3");
  EXPECT_EQ(recorder.ended().size(), 2u);
  EXPECT_THAT(bytes_of(folder / "log.txt"), HasSubstr("detector mine: program ended at 2 s, with status 3"));
  write_report(folder / "", built_in_formats());
  const std::string report = bytes_of(folder / "report.html");
  EXPECT_THAT(report, HasSubstr("mine ended before the end of the run"));
  EXPECT_THAT(report, HasSubstr("gaze controller ended before the end of the run"));
}

}  // namespace
}  // namespace saccade
