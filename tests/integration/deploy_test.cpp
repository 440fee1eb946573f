// saccade deploy on a recording that is replayed in real time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "recording/event_file.h"
#include "recording/run_files.h"
#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string source = SACCADE_SOURCE_DIR;
// Watchdog times that a busy machine keeps; the watchdog itself is tested in fake time, tests/deploy.
const std::string patient =
    " --set deploy.watchdog.safe_within_ms=1000 --set deploy.watchdog.tick_late_ms=490 --set "
    "deploy.watchdog.camera_silent_ms=500 --set deploy.watchdog.joints_stale_ms=500 --set "
    "deploy.watchdog.hang_ms=480 ";

std::vector<Event> events_of(const fs::path& file) {
  std::vector<Event> events;
  const auto reader = open_event_file(file);
  while (reader->read(events, 1 << 16) > 0) {
  }
  return events;
}

class Deploy : public testing::Test {
 protected:
  /// A run of the simulated head, 0.8 s of it.
  static void SetUpTestSuite() {
    recorded = std::make_unique<TempFolder>();
    const Outcome run =
        run_shell("'" SACCADE_BINARY "' run '" + source +
                  "/scenarios/look_at_ball.yaml' --set run.duration_s=0.8 --set expect={} --set "
                  "output.pictures=0 --set 'detectors={best: {}}' --set gaze.detector=best --out " +
                  path("run"));
    ASSERT_EQ(run.status, 0) << run.text;
  }
  static void TearDownTestSuite() { recorded.reset(); }
  static std::string path(const std::string& name) { return (*recorded / name).string(); }

  [[nodiscard]] std::string out(const std::string& name = "out") const { return (folder_ / name).string(); }
  [[nodiscard]] std::string command(const std::string& options) const {
    return "'" SACCADE_BINARY "' deploy '" + source +
           "/scenarios/robots/recording.yaml' --set recording.path=" + path("run") + patient + options;
  }

  static inline std::unique_ptr<TempFolder> recorded;
  TempFolder folder_;
};

TEST_F(Deploy, CheckPrintsALineForEachThingThatDeployNeedsAndTheRobotsOwnChecks) {
  const Outcome check =
      run_shell("'" SACCADE_BINARY "' check '" + source + "/scenarios/robots/recording.yaml' --out " + out() +
                " --set recording.path=" + path("run"));
  for (const char* what :
       {"YARP: ", "real-time priority: ", "locked memory: ", "processors: ", "shared memory: ", "disk of ",
        "guard: ", "ok    recording run: images of 128 x 128 pixels, with joints"}) {
    EXPECT_THAT(check.text, HasSubstr(what));
  }
  EXPECT_EQ(check.status, check.text.find("FAIL") == std::string::npos ? 0 : 1) << check.text;
  const Outcome missing = run_shell("'" SACCADE_BINARY "' check '" + source +
                                    "/scenarios/robots/recording.yaml' --set recording.path=" + path("none"));
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.text, AllOf(HasSubstr("FAIL  robot: "), HasSubstr("disk of ")))
      << "the rest is checked too";
}

TEST_F(Deploy, ARecordingIsReplayedInRealTimeAndItsEventsJointsAndTargetsAreInTheRunFolder) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "with a sanitizer most ticks of a second of real time are missed";
#endif
  const Outcome deployed = run_shell(command("--activate --record --out " + out()));
  ASSERT_EQ(deployed.status, 0) << deployed.text;
  EXPECT_THAT(deployed.text, AllOf(HasSubstr("ok    recording run: images of 128 x 128 pixels, with joints"),
                                   HasSubstr("ball found at"), HasSubstr("stopped: the run is over")));
  const std::vector<Event> events = events_of(out("out/events.aedat4"));
  const std::vector<Event> played = events_of(path("run/events.aedat"));
  ASSERT_LE(played.size(), events.size() + 100) << "but for those before the first reading of the joints";
  EXPECT_TRUE(std::equal(events.rbegin(), events.rend(), played.rbegin()));
  const auto joints = read_table<JointsRow>(out("out/joints.csv"));
  EXPECT_GT(joints.size(), 200u);  // of 800 ticks; a busy machine misses some
  EXPECT_FALSE(read_table<DetectionRow>(out("out/detections.csv")).empty());
  const auto gaze = read_table<GazeRow>(out("out/gaze.csv"));
  ASSERT_FALSE(gaze.empty());
  EXPECT_TRUE(gaze.back().target_m.allFinite());
  std::int64_t ticks = 0;
  for (const TimingRow& row : read_table<TimingRow>(out("out/timing.csv"))) {
    EXPECT_EQ(row.state, "active");
    ticks += row.ticks + row.missed;
  }
  EXPECT_GE(ticks, 795) << "a busy machine notices the end later";
  EXPECT_THAT(bytes_of(out("out/deploy.json")),
              AllOf(HasSubstr("\"checks\""), HasSubstr("\"state\": \"active\"")));
  EXPECT_THAT(bytes_of(out("out/log.txt")), AllOf(HasSubstr("ready"), HasSubstr("stopped: the run is over")));
  EXPECT_TRUE(fs::exists(out("out/report.html")));

  const Outcome again = run_shell("'" SACCADE_BINARY "' detect " + out());
  EXPECT_EQ(again.status, 0) << "the recorded folder can be detected on: " << again.text;
  const Outcome resolved = run_shell("'" SACCADE_BINARY "' deploy " + out("out/robot.yaml") +
                                     " --duration 0.1 --out " + out("resolved"));
  EXPECT_EQ(resolved.status, 0) << resolved.text;
}

TEST_F(Deploy, WithoutATerminalItStaysInactiveAndADryRunActivatesItself) {
  const Outcome watched = run_shell(command("--duration 0.3 --out " + out("watched") + " </dev/null"));
  EXPECT_EQ(watched.status, 0) << watched.text;
  EXPECT_THAT(bytes_of(out("watched/deploy.json")), Not(HasSubstr("\"active\"")));
  const Outcome dry = run_shell(command("--dry-run --duration 0.3 --out " + out("dry") + " </dev/null"));
  EXPECT_EQ(dry.status, 0) << dry.text;
  EXPECT_THAT(bytes_of(out("dry/deploy.json")),
              AllOf(HasSubstr("\"active\""), HasSubstr("\"dry_run\": true")));
}

TEST_F(Deploy, ASignalStopsTheHeadAndLeavesACompleteRunFolder) {
  for (const std::string signal : {"INT", "TERM"}) {
    const std::string console = out(signal + ".txt");
    const Outcome stopped =
        signal_when("grep -q ' s  active' " + console, signal,
                    command("--activate --set recording.speed=0.1 --out " + out(signal)), console);
    EXPECT_EQ(stopped.status, 0) << stopped.text;
    EXPECT_THAT(bytes_of(out(signal + "/log.txt")), HasSubstr("stopped: by a signal"));
    EXPECT_TRUE(fs::exists(out(signal + "/report.html")));
  }
}

TEST_F(Deploy, AKilledRunLeavesNoFileUnderItsFinalName) {
  const std::string console = out("console.txt");
  signal_when("grep -q ' s  active' " + console, "KILL",
              command("--activate --record --set recording.speed=0.1 --out " + out()), console);
  int unfinished = 0;
  for (const auto& entry : fs::directory_iterator(out())) {
    const std::string name = entry.path().filename();
    if (name == "robot.yaml" || name == "blackbox" || name == "lock") continue;
    EXPECT_EQ(entry.path().extension(), ".part") << entry.path();
    ++unfinished;
  }
  EXPECT_GE(unfinished, 5);
  EXPECT_EQ(run_shell(command("--duration 0.1 --force --out " + out())).status, 0)
      << "and the next one starts";
}

TEST_F(Deploy, EveryFailedCheckIsListedAndPreventsTheStart) {
  const Outcome refused =
      run_shell(command("--set calibration.width_px=130 --set recording.path=" + path("run/events.aedat") +
                        " --activate --out " + out()));
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(
      refused.text,
      AllOf(HasSubstr("FAIL  calibration is of this camera: events of 128 x 128 pixels, calibration of 130"),
            HasSubstr("FAIL  a head, if gaze.detector drives one: none"), HasSubstr("not ready")));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(Deploy, BadInputIsStatusTwo) {
  const Outcome refused = run_shell(command("--set deploy.tick=1 --set gaze.detector=worst --out " + out()));
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.text, AllOf(HasSubstr("deploy.tick"), HasSubstr("gaze.detector: found worst")));
  EXPECT_EQ(run_shell(command("--set recording.path=/nowhere --out " + out())).status, 2);
}

TEST_F(Deploy, OverloadLeavesOutEventsAndEvaluationsAndCountsThem) {
  const Outcome busy = run_shell(command(
      "--activate --set deploy.max_events_per_tick=50 --set deploy.shadows_until_ms=0 --out " + out()));
  EXPECT_EQ(busy.status, 0) << busy.text;
  std::int64_t left_out = 0;
  std::int64_t skipped = 0;
  std::int64_t missed = 0;
  for (const TimingRow& row : read_table<TimingRow>(out("out/timing.csv"))) {
    left_out += row.events_left_out;
    skipped += row.skipped;
    missed += row.missed;
  }
  std::printf("left out %ld events, skipped %ld evaluations, missed %ld ticks\n", left_out, skipped, missed);
  EXPECT_GT(left_out, 0);
  EXPECT_GT(skipped, 0);
}

/// `saccade deploy` with the backend practice and a head of this process's own.
std::string practice(const std::string& options) {
  return "'" SACCADE_BINARY "' deploy '" + source +
         "/scenarios/robots/practice.yaml' --set deploy.guard=optional --set practice.head=deploy-" +
         std::to_string(::getpid()) + patient + options;
}

TEST_F(Deploy, APracticeRunThatEndsAsAskedIsStatusZeroAndLeavesABlackBoxAndHistograms) {
  const Outcome run = run_shell(practice("--activate --record --duration 1.5 --out " + out()));
  EXPECT_EQ(run.status, 0) << run.text;
  EXPECT_THAT(bytes_of(out("out/deploy.json")),
              AllOf(HasSubstr("\"state\": \"active\""), HasSubstr("late_us_histogram"),
                    HasSubstr("\"warning\": \"no guard: none watches this head")));
  EXPECT_THAT(run.text,
              HasSubstr("active; warning: no guard: none watches this head: start `saccade guard`"));
  EXPECT_THAT(run.text, testing::ContainsRegex("active +[0-9.]+ s  NO GUARD"));
  EXPECT_THAT(bytes_of(out("out/blackbox/ticks_0.csv")), HasSubstr(",active,"));
  EXPECT_THAT(bytes_of(out("out/blackbox/messages_0.txt")), HasSubstr("stopped: the run is over"));
  EXPECT_FALSE(events_of(out("out/events.aedat4")).empty());
}

TEST_F(Deploy, AnActivationThatNeverSucceedsIsStatusOneWithTheReason) {
  const Outcome run = run_shell(practice(
      "--activate --set deploy.guard=required --set deploy.activate_within_s=0.3 --duration 5 --out " +
      out()));
  EXPECT_EQ(run.status, 1) << run.text;
  EXPECT_THAT(run.text, HasSubstr("the head was not activated: not activated within 0.3 s: deploy.guard is "
                                  "required and none watches this head"));
  EXPECT_TRUE(fs::exists(out("out/report.html"))) << "the run folder is complete";
}

TEST_F(Deploy, AKilledRunLeavesItsLastSecondsInTheBlackBox) {
  const std::string console = out("console.txt");
  // A second later: the last moments before a kill may be lost.
  signal_when("{ grep -q ' s  active' " + console + " && sleep 1; }", "KILL",
              practice("--activate --out " + out()), console);
  EXPECT_THAT(bytes_of(out("out/blackbox/ticks_0.csv")), HasSubstr(",active,"));
  EXPECT_THAT(bytes_of(out("out/blackbox/messages_0.txt")), HasSubstr("active"));
}

}  // namespace
}  // namespace saccade
