// The command line: exit status, messages, contents of the run folder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string source = SACCADE_SOURCE_DIR;
const std::string short_scenario = source + "/scenarios/look_at_ball.yaml";

Outcome saccade(const std::string& arguments, const std::string& environment = "") {
  return run_shell(environment + " '" SACCADE_BINARY "' " + arguments);
}

class Command : public testing::Test {
 protected:
  [[nodiscard]] std::string out(const std::string& name) const { return (folder_ / name).string(); }
  /// No file that looks whole, none half-written.
  void expect_nothing_left(const std::string& name) const {
    EXPECT_TRUE(!fs::exists(out(name)) || fs::is_empty(out(name)));
  }

  TempFolder folder_;
};

TEST_F(Command, TheSameScenarioAndSeedGiveTheSameBytesWhateverTheNumberOfThreads) {
  const std::string run = "run '" + short_scenario + "' --set run.duration_s=0.3 --set expect={} --seed 7 ";
  ASSERT_EQ(saccade(run + "--set run.threads=1 --out " + out("one")).status, 0);
  ASSERT_EQ(saccade(run + "--set run.threads=1 --out " + out("again")).status, 0);
  ASSERT_EQ(saccade(run + "--set run.threads=3 --out " + out("three")).status, 0);
  for (const char* file : {"events.aedat", "detections.csv", "streaming.csv", "gaze.csv", "truth.csv",
                           "joints.csv", "figures.json"}) {
    const std::string first = bytes_of(folder_ / "one" / file);
    EXPECT_GT(first.size(), 100U) << file;
    EXPECT_TRUE(first == bytes_of(folder_ / "again" / file)) << file << " differs from run to run";
    EXPECT_TRUE(first == bytes_of(folder_ / "three" / file)) << file << " depends on the number of threads";
  }
}

TEST_F(Command, ReprojectedImagesGiveTheSameBytesWhateverTheNumberOfThreads) {
  const std::string run =
      "run '" + short_scenario +
      "' --set render.method=keyframes --set run.duration_s=0.3 --set expect={} --seed 7 ";
  ASSERT_EQ(saccade(run + "--set run.threads=1 --out " + out("one")).status, 0);
  ASSERT_EQ(saccade(run + "--set run.threads=2 --out " + out("two")).status, 0);
  for (const char* file : {"events.aedat", "detections.csv", "gaze.csv", "truth.csv", "figures.json"}) {
    const std::string first = bytes_of(folder_ / "one" / file);
    EXPECT_GT(first.size(), 100U) << file;
    EXPECT_TRUE(first == bytes_of(folder_ / "two" / file)) << file << " depends on the number of threads";
  }
}

TEST_F(Command, BothEyesAreRecordedWithTheSameBytesWhateverTheNumberOfThreads) {
  const std::string run = "run '" + short_scenario +
                          "' --set eyes=both --set run.duration_s=0.25 --set render.max_interval_ms=1 "
                          "--set expect={} --seed 7 --set output.pictures=2 ";
  ASSERT_EQ(saccade(run + "--set run.threads=1 --out " + out("one")).status, 0);
  ASSERT_EQ(saccade(run + "--set run.threads=3 --out " + out("three")).status, 0);
  for (const char* file : {"events.aedat", "detections.csv", "gaze.csv", "truth.csv", "truth_right.csv"}) {
    const std::string first = bytes_of(folder_ / "one" / file);
    EXPECT_GT(first.size(), 100U) << file;
    EXPECT_TRUE(first == bytes_of(folder_ / "three" / file)) << file << " depends on the number of threads";
  }
  EXPECT_THAT(saccade("info " + out("one")).text, testing::ContainsRegex("both +left +right"));
  EXPECT_THAT(saccade("info --camera left " + out("one/events.aedat")).text, Not(HasSubstr("both")));
  EXPECT_THAT(bytes_of(folder_ / "one/report.html"), HasSubstr("right eye at "));

  ASSERT_EQ(saccade("detect " + out("one") + " --camera right --out " + out("right")).status, 0);
  EXPECT_EQ(bytes_of(folder_ / "right/truth.csv"), bytes_of(folder_ / "one/truth_right.csv"));
  ASSERT_EQ(saccade("detect " + out("one") + " --out " + out("left")).status, 0);
  EXPECT_NE(bytes_of(folder_ / "left/detections.csv"), bytes_of(folder_ / "right/detections.csv"));
}

TEST_F(Command, BothEyesFixateTheBallAndStereoLooksThroughEach) {
  const Outcome run = saccade(
      "run '" + short_scenario +
      "' --set eyes=both --set gaze.stereo=true --set gaze.detector=best --set 'detectors={best: {}}' "
      "--set output.pictures=0 --set 'expect={gaze.fixation_error_deg.median: [0, 2], "
      "right_eye.fixation_error_deg.median: [0, 2], right_eye.in_view_ratio: [1, 1]}' --out " +
      out("run"));
  EXPECT_EQ(run.status, 0) << run.text;
  EXPECT_GT(bytes_of(folder_ / "run/detections_right.csv").size(), 1000U);
  EXPECT_NE(bytes_of(folder_ / "run/detections_right.csv"), bytes_of(folder_ / "run/detections.csv"));
  EXPECT_THAT(bytes_of(folder_ / "run/scenario.yaml"), HasSubstr("right_calibration:"));
}

TEST_F(Command, RunsThatStartInOneFolderAtOnceDoNotMix) {
  const std::string run = "'" SACCADE_BINARY "' run '" + short_scenario +
                          "' --set run.duration_s=0.1 --set expect={} --set output.pictures=0 ";
  std::string start;
  for (const char* seed : {"1", "2", "3"})
    start += run + "--seed " + seed + " --force --out " + out("run") + " > " + out(seed) + " 2>&1 & ";
  run_shell(start + "wait");
  EXPECT_FALSE(fs::exists(folder_ / "run/lock"));
  const std::string scenario = bytes_of(folder_ / "run/scenario.yaml");
  const std::string seed = scenario.substr(scenario.find("\nseed: ") + 7, 1);
  ASSERT_EQ(run_shell(run + "--seed " + seed + " --out " + out("alone")).status, 0);
  for (const char* file : {"scenario.yaml", "events.aedat", "truth.csv", "detections.csv", "figures.json"})
    EXPECT_TRUE(bytes_of(folder_ / "run" / file) == bytes_of(folder_ / "alone" / file)) << file;
}

TEST_F(Command, MetricsStateTheBoundOfAcquisition) {
  const std::string run =
      "run '" + short_scenario + "' --set run.duration_s=0.1 --set expect={} --set output.pictures=0 --out ";
  ASSERT_EQ(saccade(run + out("six")).status, 0);
  EXPECT_THAT(bytes_of(folder_ / "six/figures.json"), HasSubstr("\"acquire_within_deg\": 6.0"));
  ASSERT_EQ(saccade(run + out("two") + " --set gaze.acquire_within_deg=null").status, 0);
  EXPECT_THAT(bytes_of(folder_ / "two/figures.json"), HasSubstr("\"acquire_within_deg\": 2.0"));
}

TEST_F(Command, CompareRejectsAToleranceForNoFigureAndFindsRunsWithoutAResultDifferent) {
  const std::string run =
      "run '" + short_scenario + "' --set run.duration_s=0.05 --set expect={} --set output.pictures=0 --out ";
  ASSERT_EQ(saccade(run + out("set/one")).status, 0);
  EXPECT_EQ(saccade("compare " + out("set") + " " + out("set")).status, 0);
  EXPECT_EQ(saccade("compare " + out("set") + " " + out("set") + " --tolerance foo=1").status, 2);
  fs::create_directories(folder_ / "set/two");
  folder_.write("set/two/scenario.yaml", "name: killed\n");
  EXPECT_EQ(saccade("compare " + out("set") + " " + out("set")).status, 3);
}

TEST_F(Command, AnotherSeedGivesOtherEvents) {
  const std::string run = "run '" + short_scenario + "' --set run.duration_s=0.3 --set expect={} ";
  ASSERT_EQ(saccade(run + "--seed 1 --out " + out("a")).status, 0);
  ASSERT_EQ(saccade(run + "--seed 2 --out " + out("b")).status, 0);
  EXPECT_NE(bytes_of(folder_ / "a/events.aedat"), bytes_of(folder_ / "b/events.aedat"));
}

TEST_F(Command, ARunLeavesEveryFileOfTheRunFolderAndTheResolvedScenarioGivesTheSameRun) {
  const std::string options = " --set run.duration_s=0.4 --set expect={} --set output.video=true ";
  ASSERT_EQ(saccade("run '" + short_scenario + "'" + options + "--out " + out("run")).status, 0);
  for (const char* file :
       {"scenario.yaml", "events.aedat", "joints.csv", "truth.csv", "detections.csv", "gaze.csv",
        "metrics.json", "report.html", "video.mp4", "streaming.csv", "figures.json"}) {
    EXPECT_GT(bytes_of(folder_ / "run" / file).size(), 100U) << file;
  }
  EXPECT_THAT(bytes_of(folder_ / "run/log.txt"), HasSubstr(" s  ball ")) << "found, or never found";
  ASSERT_EQ(saccade("run " + out("run/scenario.yaml") + " --out " + out("again")).status, 0);
  EXPECT_EQ(bytes_of(folder_ / "run/events.aedat"), bytes_of(folder_ / "again/events.aedat"));
  EXPECT_EQ(bytes_of(folder_ / "run/gaze.csv"), bytes_of(folder_ / "again/gaze.csv"));
}

TEST_F(Command, AFrameCameraIsScoredBesideTheDetectorsAndLeavesTheirEventsUnchanged) {
  const std::string run = "run '" + short_scenario + "' --set run.duration_s=0.4 --set expect={} ";
  ASSERT_EQ(saccade(run + "--out " + out("without")).status, 0);
  const Outcome with = saccade(run + "--set frame_30hz.radius_px=[4,20] --seed 1 --out " + out("with"));
  ASSERT_EQ(with.status, 0) << with.text;
  EXPECT_EQ(bytes_of(folder_ / "without/events.aedat"), bytes_of(folder_ / "with/events.aedat"));
  EXPECT_THAT(bytes_of(folder_ / "without/metrics.json"), Not(HasSubstr("frame_30hz")));
  EXPECT_THAT(bytes_of(folder_ / "with/metrics.json"), HasSubstr("\"frame_30hz\""));
  EXPECT_THAT(bytes_of(folder_ / "with/metrics.json"), HasSubstr("\"frame_30hz.radius_px\": \"[4,20]\""));
  EXPECT_THAT(bytes_of(folder_ / "with/metrics.json"), Not(HasSubstr("run.duration_s")));

  // Exposures of 20 ms that begin every 1/30 s end in 12 ticks of 400; the slow ball is found in all of them.
  const std::string rows = bytes_of(folder_ / "with/detections.csv");
  int found = 0;
  for (std::size_t at = 0; (at = rows.find(",frame_30hz,", at)) != std::string::npos; ++at) ++found;
  EXPECT_EQ(found, 12);
  EXPECT_THAT(rows, HasSubstr("\n20000,frame_30hz,"));
}

TEST_F(Command, RunsAreReportedTogetherByScenarioAndSettings) {
  const std::string run = "run '" + short_scenario + "' --set run.duration_s=0.3 --set expect={} ";
  ASSERT_EQ(saccade(run + "--seed 1 --out " + out("a")).status, 0);
  ASSERT_EQ(saccade(run + "--seed 2 --out " + out("b")).status, 0);
  ASSERT_EQ(saccade(run + "--set lab.clutter=rectilinear --out " + out("c")).status, 0);
  const Outcome report =
      saccade("report " + out("a") + " " + out("b") + " " + out("c") + " --out " + out("all"));
  ASSERT_EQ(report.status, 0) << report.text;
  EXPECT_THAT(bytes_of(folder_ / "all/report.html"), HasSubstr("lab.clutter"));
  const std::string means = bytes_of(folder_ / "all/figures/means.csv");
  EXPECT_EQ(std::count(means.begin(), means.end(), '\n'), 5)
      << "a head line, two groups with two detectors each: " << means;
  bool pictured = false;
  for (const auto& file : fs::directory_iterator(folder_ / "a/frames")) {
    pictured = pictured || file.path().filename().string().find("paper_directed_hough") != std::string::npos;
  }
  EXPECT_TRUE(pictured) << "no Hough space was saved";
  const Outcome wrong = saccade("report " + out("a") + " " + out("none"));
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.text, HasSubstr(out("none")));
}

TEST_F(Command, AnUnmetExpectationIsStatusThreeAndIsNamed) {
  const Outcome outcome = saccade("run '" + short_scenario + "' --set run.duration_s=0.1 --out " +
                                  out("run") + " --set 'expect={gaze.in_view_ratio: [2, 3]}'");
  EXPECT_EQ(outcome.status, 3) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("expect: gaze.in_view_ratio is"));
  EXPECT_TRUE(fs::exists(folder_ / "run/report.html"));
}

TEST_F(Command, AMissingScenarioIsOneLineAndStatusTwo) {
  const Outcome outcome = saccade("run nowhere.yaml --out " + out("run"));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.text, HasSubstr("nowhere.yaml"));
  EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
  expect_nothing_left("run");
}

TEST_F(Command, ARunFolderThatExistsIsRejectedWithoutForceAndAFolderWithOtherThingsAlways) {
  const std::string run = "run '" + short_scenario + "' --set run.duration_s=0.05 --set expect={} --out ";
  ASSERT_EQ(saccade(run + out("run")).status, 0);
  const std::string before = bytes_of(folder_ / "run/metrics.json");
  EXPECT_EQ(saccade(run + out("run")).status, 2);
  EXPECT_EQ(bytes_of(folder_ / "run/metrics.json"), before);
  EXPECT_EQ(saccade(run + out("run") + " --force").status, 0);

  fs::create_directories(folder_ / "mine");
  folder_.write("mine/thesis.tex", "years of work");
  EXPECT_EQ(saccade(run + out("mine") + " --force").status, 2);
  EXPECT_EQ(bytes_of(folder_ / "mine/thesis.tex"), "years of work");
}

TEST_F(Command, WithoutOpenGlTheRunFailsWithOneLineAndLeavesNothing) {
  const Outcome outcome = saccade("run '" + short_scenario + "' --set render.backend=egl --out " + out("run"),
                                  "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.text, HasSubstr("EGL"));
  EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
  expect_nothing_left("run");
}

/// Whether `saccade --version` lists a backend as one that works.
bool draws(const std::string& backend) {
  const std::string text = saccade("--version").text;
  return text.find("\nrender.backend " + backend + ": " + backend + ", ") != std::string::npos;
}

TEST_F(Command, EveryBackendOfOpenGlGivesTheSameBytes) {
  const std::string run = "run '" + short_scenario + "' --set run.duration_s=0.3 --set expect={} --seed 7 ";
  for (const std::string backend : {"egl", "osmesa"}) {
    if (!draws(backend)) GTEST_SKIP() << "NOT COMPARED: " << saccade("--version").text;
    ASSERT_EQ(saccade(run + "--set render.backend=" + backend + " --out " + out(backend)).status, 0);
    EXPECT_THAT(bytes_of(folder_ / backend / "scenario.yaml"), HasSubstr("; " + backend + ", llvmpipe"));
  }
  for (const char* file : {"events.aedat", "detections.csv", "gaze.csv", "truth.csv"}) {
    const std::string first = bytes_of(folder_ / "egl" / file);
    EXPECT_GT(first.size(), 100U) << file;
    EXPECT_TRUE(first == bytes_of(folder_ / "osmesa" / file)) << file << " differs between EGL and OSMesa";
  }
}

TEST_F(Command, MujocoGlIsWhatTheBackendAutoStandsFor) {
  const std::string run = "run '" + short_scenario + "' --set run.duration_s=0.05 --set expect={} --out ";
  for (const std::string backend : {"egl", "osmesa"}) {
    if (!draws(backend)) continue;
    ASSERT_EQ(saccade(run + out(backend), "MUJOCO_GL=" + backend).status, 0);
    EXPECT_THAT(bytes_of(folder_ / backend / "scenario.yaml"), HasSubstr("; " + backend + ", "));
    ASSERT_EQ(saccade(run + out("key") + " --force --set render.backend=" + backend, "MUJOCO_GL=wgl").status,
              0)
        << "with a key the variable is not read";
  }
  const Outcome nonsense = saccade(run + out("nonsense"), "MUJOCO_GL=wgl");
  EXPECT_EQ(nonsense.status, 2);
  EXPECT_THAT(nonsense.text,
              HasSubstr("MUJOCO_GL: found wgl, expected egl, osmesa, or that the variable is not set\n"));
  EXPECT_EQ(std::count(nonsense.text.begin(), nonsense.text.end(), '\n'), 1) << nonsense.text;
  expect_nothing_left("nonsense");
}

TEST_F(Command, NothingOfOpenGlsOwnMessagesIsPrinted) {
  const Outcome run =
      saccade("run '" + short_scenario + "' --set run.duration_s=0.05 --set expect={} --out " + out("run"),
              "env -u HOME -u DISPLAY XDG_CACHE_HOME=/proc/nowhere XDG_RUNTIME_DIR=/proc/nowhere");
  ASSERT_EQ(run.status, 0) << run.text;
  for (const char* word : {"MESA", "Mesa", "libEGL", "libGL", "shader cache", "XDG_RUNTIME_DIR"})
    EXPECT_THAT(run.text, Not(HasSubstr(word)));
}

TEST_F(Command, ARecordingThatIsMissingEmptyTruncatedOrWithoutEventsIsBadInput) {
  const Outcome missing = saccade("detect nowhere.aedat");
  EXPECT_EQ(missing.status, 2);
  EXPECT_THAT(missing.text, HasSubstr("nowhere.aedat"));

  folder_.write("empty.aedat", "");
  EXPECT_EQ(saccade("detect " + out("empty.aedat")).status, 2);

  folder_.write("skin.log", "7 1571751370.660680 AE (911 16777216)\n");
  const Outcome skin = saccade("detect " + out("skin.log"));
  EXPECT_EQ(skin.status, 2);
  EXPECT_THAT(skin.text, HasSubstr("no events of a camera"));
  EXPECT_THAT(saccade("info " + out("skin.log")).text, HasSubstr("1 skin events"));

  folder_.write("cut.aedat", "#!AER-DAT2.0\r\n" + std::string(8, '\0') + "abc");
  const Outcome cut = saccade("detect " + out("cut.aedat") + " --out " + out("run"));
  EXPECT_EQ(cut.status, 2) << cut.text;
  EXPECT_THAT(cut.text, HasSubstr("cut.aedat"));
  EXPECT_FALSE(fs::exists(folder_ / "run/metrics.json"));
}

TEST_F(Command, UnknownWordsOnTheCommandLineAreUsage) {
  EXPECT_EQ(saccade("").status, 2);
  EXPECT_EQ(saccade("dance").status, 2);
  EXPECT_EQ(saccade("run").status, 2);
  EXPECT_EQ(saccade("--help").status, 0);
  const Outcome version = saccade("--version");
  EXPECT_EQ(version.status, 0);
  for (const char* part : {"\nMuJoCo ", "\nOpenGL ", "\nrender.backend egl: ", "\nrender.backend osmesa: "})
    EXPECT_THAT(version.text, HasSubstr(part));
}

TEST_F(Command, ARunFolderIsARecordingThatDetectReadsBack) {
  ASSERT_EQ(
      saccade("run '" + short_scenario + "' --set run.duration_s=0.6 --set expect={} --out " + out("run"))
          .status,
      0);
  const Outcome outcome = saccade("detect " + out("run/events.aedat") + " --out " + out("detect"));
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_GT(bytes_of(folder_ / "detect/detections.csv").size(), 1000U);
}

TEST_F(Command, DetectReplaysARunFolderWithItsJointsAndScoresItAgainstItsTruth) {
  // No event is late in the run, as none is in a recording.
  ASSERT_EQ(
      saccade("run '" + short_scenario +
              "' --set run.duration_s=0.6 --set render.max_interval_ms=1 --set expect={} --out " + out("run"))
          .status,
      0);
  const Outcome outcome = saccade("detect " + out("run") + " --out " + out("again"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  // The same events at the same ticks: the same detections, but for the tick at which the joints begin.
  const auto rows_of = [&](const std::string& file) {
    std::vector<std::string> rows;
    std::istringstream lines(bytes_of(folder_ / file));
    for (std::string line; std::getline(lines, line);) {
      if (line.find(",paper_directed,") != std::string::npos && !line.starts_with("1000,"))
        rows.push_back(line);
    }
    return rows;
  };
  EXPECT_THAT(outcome.text, Not(HasSubstr("go back in time"))) << "events before the joints do not";
  EXPECT_GT(rows_of("run/detections.csv").size(), 100U);
  EXPECT_EQ(rows_of("again/detections.csv"), rows_of("run/detections.csv"));
  const std::string metrics = bytes_of(folder_ / "again/metrics.json");
  EXPECT_THAT(metrics, Not(HasSubstr("\"best\""))) << "the run has the paper's detectors";
  EXPECT_THAT(metrics, Not(HasSubstr("\"chances\": 0,")));
  EXPECT_TRUE(fs::exists(folder_ / "again/report.html"));

  fs::create_directory(folder_ / "empty");
  const Outcome wrong = saccade("detect " + out("empty"));
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.text, HasSubstr("metrics.json"));
}

TEST_F(Command, TruthOutsideTheTimeSpanOfTheEventsIsBadInputThatNamesBothSpansAndTheOffset) {
  std::string events;
  for (int i = 0; i < 1000; ++i) events += std::to_string(5'000'000 + 1000 * i) + " 64 64 1\n";
  folder_.write("events.txt", events);
  const std::string detect = "detect " + out("events.txt") + " --size 128x128 --truth " + out("truth.csv");
  for (const std::int64_t start_us : {std::int64_t{1'000'000}, std::int64_t{1'700'000'000'000'000}}) {
    std::string truth = "t_us,x_px,y_px,r_px\n";
    for (int i = 0; i < 10; ++i) truth += std::to_string(start_us + 100'000 * i) + ",64,64,20\n";
    folder_.write("truth.csv", truth);
    const Outcome outcome = saccade(detect);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    const bool before = start_us < 5'000'000;
    EXPECT_THAT(outcome.text, HasSubstr(before ? "truth from 1.000 to 1.900 s, events from 5.000 to 5.999 s"
                                               : "truth from 1700000000.000 to 1700000000.900 s"));
    EXPECT_THAT(outcome.text, HasSubstr("with " + std::to_string(5'000'000 - start_us) + " us added"));
  }
}

TEST_F(Command, HiddenBallsInTheTruthOfARecordingAreNoChances) {
  std::string events;
  for (int i = 0; i < 1000; ++i) events += std::to_string(1000 * i) + " 64 64 1\n";
  folder_.write("events.txt", events);
  folder_.write("truth.csv",
                "t_us,x_px,y_px,r_px,visible,x_m,y_m,z_m\n100000,64,64,20,1,,,\n200000,64,64,20,0.4,,,\n"
                "300000,64,64,20,0.5,,,\n400000,64,64,20,0,,,\n");
  const Outcome outcome = saccade("detect " + out("events.txt") + " --size 128x128 --truth " +
                                  out("truth.csv") + " --out " + out("run"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_THAT(bytes_of(folder_ / "run/metrics.json"), HasSubstr("\"chances\": 2,"));
}

TEST_F(Command, LabelsNameTheCauseOfEachEventAndChangeNothingElse) {
  const std::string run =
      "run '" + short_scenario + "' --set run.duration_s=0.4 --set expect={} --set output.events=csv ";
  ASSERT_EQ(saccade(run + "--out " + out("without")).status, 0);
  ASSERT_EQ(saccade(run + "--set output.labels=true --out " + out("with")).status, 0);
  const std::string events = bytes_of(folder_ / "with/events.csv");
  EXPECT_EQ(events, bytes_of(folder_ / "without/events.csv"));
  EXPECT_EQ(bytes_of(folder_ / "with/detections.csv"), bytes_of(folder_ / "without/detections.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "without/labels.csv"));
  EXPECT_THAT(bytes_of(folder_ / "without/metrics.json"), Not(HasSubstr("clutter")));

  const std::string labels = bytes_of(folder_ / "with/labels.csv");
  std::istringstream event_lines(events);
  std::istringstream label_lines(labels);
  std::string event;
  std::string label;
  std::getline(label_lines, label);
  EXPECT_EQ(label, "t_us,x,y,p,cause,object");
  std::getline(event_lines, event);
  int rows = 0;
  for (; std::getline(event_lines, event); ++rows) {
    ASSERT_TRUE(std::getline(label_lines, label));
    ASSERT_TRUE(label.starts_with(event + ",")) << label;
  }
  EXPECT_FALSE(std::getline(label_lines, label));
  EXPECT_GT(rows, 100);
  EXPECT_THAT(bytes_of(folder_ / "with/metrics.json"), HasSubstr("\"clutter_per_detection\""));
  EXPECT_THAT(bytes_of(folder_ / "with/report.html"), HasSubstr("clutter_by_detector"));
}

TEST_F(Command, ARecordingSurvivesConversionToTextAndBack) {
  ASSERT_EQ(
      saccade("run '" + short_scenario + "' --set run.duration_s=0.3 --set expect={} --out " + out("run"))
          .status,
      0);
  ASSERT_EQ(saccade("convert " + out("run/events.aedat") + " " + out("e.csv")).status, 0);
  ASSERT_EQ(saccade("convert " + out("e.csv") + " " + out("e.aedat") + " --size 128x128").status, 0);
  const auto info = [&](const std::string& name) {
    const std::string text = saccade("info " + out(name)).text;
    return text.substr(text.find('\n'));  // behind the name of the file
  };
  const std::string first = info("run/events.aedat");
  EXPECT_EQ(first, info("e.aedat"));
  EXPECT_THAT(first, HasSubstr("events"));
}

}  // namespace
}  // namespace saccade
