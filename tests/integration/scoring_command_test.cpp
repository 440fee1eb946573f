// What a user scores: detections made elsewhere, recordings without a ball, recordings with the head's joints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "recording/event_file.h"
#include "recording/run_files.h"
#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

const std::string source = SACCADE_SOURCE_DIR;

Outcome saccade(const std::string& arguments) { return run_shell("'" SACCADE_BINARY "' " + arguments); }

class Scores : public testing::Test {
 protected:
  [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] Json json_in(const std::string& name) const { return Json::parse(bytes_of(folder_ / name)); }

  /// Some tenths of a second of eyes that move, with `best`; the shortest interval of images gives every event in its tick.
  void run_eyes(const std::string& name, const std::string& options = "", const char* duration_s = "0.3") {
    const Outcome run = saccade(
        "run '" + source + "/scenarios/eye_move.yaml' --set expect={} --set run.duration_s=" + duration_s +
        " --set 'detectors={best: {radius_px: [4, 14]}, paper_directed: {radius_px: [4, 14]}}' " +
        "--set output.pictures=0 --set render.max_interval_ms=1 --set camera.preset=pinhole " + options +
        " --out " + at(name));
    ASSERT_EQ(run.status, 0) << run.text;
  }
  /// A second of noise.
  void write_noise(const std::string& name) const {
    std::vector<Event> events;
    for (int i = 0; i < 20'000; ++i)
      events.push_back({1'000'000 + i * 50, static_cast<std::uint16_t>(i * 7919 % 128),
                        static_cast<std::uint16_t>(i * 104729 % 127), i % 3 == 0, 0});
    const auto writer = create_event_file(folder_ / name, {128, 128});
    writer->write(events);
    writer->commit();
  }

  TempFolder folder_;
};

TEST_F(Scores, OfARunsOwnDetectionsAreThoseOfTheRun) {
  run_eyes("run");
  const Json expected = json_in("run/metrics.json")["detectors"];
  const std::string thresholds = "--threshold best=" + expected["best"]["threshold"].dump() + " ";
  const Outcome scored = saccade("score " + at("run/detections.csv") + " --truth " + at("run/truth.csv") +
                                 " --json " + thresholds);
  ASSERT_EQ(scored.status, 0) << scored.text;
  const Json detectors = Json::parse(scored.text)["detectors"];
  for (const char* key :
       {"average_precision", "precision_at_recall", "pr_curve", "chances", "threshold", "precision", "recall",
        "detection_rate_hz", "position_error_px", "lag_ms", "observations", "inliers"})
    EXPECT_EQ(detectors["best"][key], expected["best"][key]) << key;
  const Json& other = detectors["paper_directed"];
  EXPECT_EQ(other["average_precision"], expected["paper_directed"]["average_precision"]);
  for (const char* key : {"threshold", "precision", "recall", "observations", "lag_ms", "us_per_event"})
    EXPECT_TRUE(other[key].is_null()) << key << " without a threshold";
  EXPECT_TRUE(other["position_error_px"]["median"].is_null());
  const Outcome words = saccade("score " + at("run/detections.csv") + " --truth " + at("run/truth.csv"));
  EXPECT_THAT(words.text, HasSubstr("best: average precision 0."));
}

TEST_F(Scores, OfDetectionsMadeElsewhereNeedSixColumnsAndSparseTruth) {
  folder_.write("mine.csv",
                "t_us,detector,x_px,y_px,r_px,score\n1000,ring,50,50,20,0.9\n2000,ring,0,0,5,0.8\n3000,ring,"
                "51,50,20,0.7\n");
  folder_.write("truth.csv", "t_us,x_px,y_px,r_px\n1000,50,50,20\n3000,50,50,20\n");
  const Outcome scored =
      saccade("score " + at("mine.csv") + " --truth " + at("truth.csv") + " --threshold ring=0.8 --json");
  ASSERT_EQ(scored.status, 0) << scored.text;
  const Json ring = Json::parse(scored.text)["detectors"]["ring"];
  EXPECT_EQ(ring["average_precision"], 1.0) << "there is no truth at 2 ms";
  EXPECT_EQ(ring["recall"], 0.5);
  EXPECT_TRUE(ring["detection_rate_hz"]["mean"].is_null());
}

TEST_F(Scores, OfDetectionsOnTheRecordedEventsFollowFromTheGroundTruthOfTheRun) {
  run_eyes("run", "--set output.events=aedat4");
  ASSERT_EQ(
      saccade("detect " + at("run/events.aedat4") + " --set radius_px=[4,14] --out " + at("bare")).status, 0);
  const auto rows = read_table<DetectionRow>(folder_ / "bare/detections.csv");
  ASSERT_GT(rows.size(), 100U);
  for (const DetectionRow& row : rows) ASSERT_EQ(row.t_us % 1000, 0) << "as the ground truth";
  const Outcome scored =
      saccade("score " + at("bare/detections.csv") + " --truth " + at("run/truth.csv") + " --json");
  ASSERT_EQ(scored.status, 0) << scored.text;
  const double precision =
      Json::parse(scored.text)["detectors"]["paper_directed"]["average_precision"].get<double>();
  const double expected =
      json_in("run/metrics.json")["detectors"]["paper_directed"]["average_precision"].get<double>();
  EXPECT_GT(expected, 0.1);
  EXPECT_NEAR(precision, expected, 0.05);
}

TEST_F(Scores, OfDetectionsBetweenTheInstantsOfTheTruthAreRefusedOrWarnedOf) {
  std::string truth = "t_us,x_px,y_px,r_px\n", between = "t_us,detector,x_px,y_px,r_px,score\n",
              half = between;
  for (int ms = 1; ms <= 20; ++ms) {
    const std::string circle = ",50,50,20";
    truth += std::to_string(1000 * ms) + circle + "\n";
    between += std::to_string(1000 * ms + 500) + ",ring" + circle + ",0.9\n";
    half += std::to_string(500 * ms + 1000) + ",ring" + circle + ",0.9\n";
  }
  folder_.write("truth.csv", truth);
  folder_.write("between.csv", between);
  folder_.write("half.csv", half);
  const Outcome refused = saccade("score " + at("between.csv") + " --truth " + at("truth.csv"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.text,
              HasSubstr("the truth has t_us = 1000, 2000, 3000, ..., the detections 1500, 2500, "
                        "3500, ..."));
  const Outcome warned = saccade("score " + at("half.csv") + " --truth " + at("truth.csv"));
  EXPECT_EQ(warned.status, 0);
  EXPECT_THAT(warned.text,
              HasSubstr("warning: ring: 10 of 20 detections lie between the instants of the truth"));
}

TEST_F(Scores, OfARunFolderAreThoseOfItsOwnDetectorsUnlessOthersAreGiven) {
  run_eyes("run",
           "--set detectors.best.radius_px=[5,13] --set 'detectors.mine={preset: paper_full, radius_px: [6, "
           "12]}'");
  const Outcome own = saccade("detect " + at("run") + " --out " + at("own"));
  ASSERT_EQ(own.status, 0) << own.text;
  EXPECT_THAT(own.text, HasSubstr("saccade: the detectors of " + at("run/scenario.yaml") +
                                  ": best, paper_directed, mine"));
  const std::string detectors = bytes_of(folder_ / "own/detectors.yaml");
  EXPECT_THAT(detectors, HasSubstr("radius_px: [5, 13]"));
  EXPECT_THAT(detectors, HasSubstr("radius_px: [6, 12]"));
  EXPECT_NEAR(json_in("own/metrics.json")["detectors"]["mine"]["average_precision"].get<double>(),
              json_in("run/metrics.json")["detectors"]["mine"]["average_precision"].get<double>(), 0.05);
  const Outcome set = saccade("detect " + at("run") + " --set mine.threshold=0.5 --out " + at("set"));
  ASSERT_EQ(set.status, 0) << set.text;
  EXPECT_EQ(json_in("set/metrics.json")["detectors"]["mine"]["threshold"], 0.5);
  EXPECT_THAT(bytes_of(folder_ / "set/detectors.yaml"), HasSubstr("radius_px: [6, 12]"));
  folder_.write("other.yaml", "detectors: {paper_full: {}}\n");
  const Outcome other =
      saccade("detect " + at("run") + " --config " + at("other.yaml") + " --json 2>/dev/null");
  ASSERT_EQ(other.status, 0);
  EXPECT_EQ(Json::parse(other.text)["detectors"].size(), 1U);
  const Outcome slip = saccade("detect " + at("run") + " --set bset.threshold=0.5");
  EXPECT_EQ(slip.status, 2);
  EXPECT_THAT(slip.text, HasSubstr("found bset, expected a detector's name or a key; did you mean best?"));
  run_eyes("none", "--set 'detectors={}'");
  EXPECT_EQ(Json::parse(saccade("detect " + at("none") + " --json 2>/dev/null").text)["detectors"].size(),
            3U);
}

TEST_F(Scores, WithACalibrationAndNoJointsNameTheCalibration) {
  run_eyes("run");
  Json calibration = json_in("run/metrics.json")["calibration"];
  calibration["fx_px"] = calibration["fx_px"].get<double>() * 2.0;
  folder_.write("calibration.yaml", "calibration: " + calibration.dump() + "\n");
  const std::string detect = "detect " + at("run/events.aedat") + " --json ";
  const Json without = Json::parse(saccade(detect + "2>/dev/null").text);
  const Json with =
      Json::parse(saccade(detect + "--calibration " + at("calibration.yaml") + " 2>/dev/null").text);
  EXPECT_FALSE(without.contains("calibration"));
  EXPECT_EQ(with["calibration"]["fx_px"], calibration["fx_px"]);
}

TEST_F(Scores, RejectTablesAndThresholdsThatDoNotFit) {
  folder_.write("mine.csv", "t_us,detector,x_px,y_px,r_px,score\n1000,ring,50,50,20,0.9\n");
  folder_.write("late.csv", "t_us,x_px,y_px,r_px\n9000000,50,50,20\n");
  folder_.write("truth.csv", "t_us,x_px,y_px,r_px\n1000,50,50,20\n");
  folder_.write("empty.csv", "t_us,x_px,y_px,r_px\n");
  const auto refused = [&](const std::string& arguments, const std::string& message) {
    const Outcome outcome = saccade("score " + arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_THAT(outcome.text, HasSubstr(message)) << arguments;
  };
  const std::string mine = at("mine.csv") + " --truth ";
  refused(mine + at("late.csv"), "detections from 0.001 to 0.001 s, truth from 9.000 to 9.000 s");
  refused(mine + at("empty.csv"), "a table without rows");
  refused(mine + at("mine.csv"), "mine.csv:1: found t_us,detector");
  refused(mine + at("truth.csv") + " --threshold disc=0.5", "--threshold: found disc, expected one of ring");
  refused(mine + at("truth.csv") + " --threshold ring", "--threshold: found ring, expected NAME=V");
  refused(at("mine.csv"), "--truth is required");
}

TEST_F(Scores, OfARecordingWithoutABallHaveAnAlarmRatioWhenAskedFor) {
  write_noise("noise.aedat");
  ASSERT_EQ(saccade("detect " + at("noise.aedat") + " --no-ball --out " + at("none")).status, 0);
  ASSERT_EQ(saccade("detect " + at("noise.aedat") + " --out " + at("unknown")).status, 0);
  const Json no_ball = json_in("none/metrics.json")["detectors"];
  for (const auto& [name, detector] : no_ball.items()) {
    ASSERT_TRUE(detector["alarm_ratio"].is_number()) << name;
    int alarms = 0;
    const double threshold = detector["threshold"].get<double>();
    for (const DetectionRow& row : read_table<DetectionRow>(folder_ / "none/detections.csv"))
      alarms += row.detector == name && row.score >= threshold ? 1 : 0;
    EXPECT_NEAR(detector["alarm_ratio"].get<double>(), alarms / 1000.0, 1e-12) << name;
    EXPECT_EQ(detector["observations"], alarms) << name;
    EXPECT_EQ(detector["precision"].is_null(), alarms == 0) << name;
  }
  const Json unknown = json_in("unknown/metrics.json")["detectors"];
  for (const auto& [name, detector] : unknown.items()) EXPECT_TRUE(detector["alarm_ratio"].is_null()) << name;
  folder_.write("truth.csv", "t_us,x_px,y_px,r_px\n1500000,50,50,20\n");
  const Outcome both = saccade("detect " + at("noise.aedat") + " --no-ball --truth " + at("truth.csv") +
                               " --out " + at("both"));
  EXPECT_EQ(both.status, 2);
  run_eyes("run");
  const Outcome ball = saccade("detect " + at("run") + " --no-ball --out " + at("ball"));
  EXPECT_EQ(ball.status, 2);
  EXPECT_THAT(ball.text, HasSubstr("--no-ball: found a recording whose truth has a ball"));
}

TEST_F(Scores, OfAWorldWithoutABallHaveAnAlarmRatioAndItsRecordingHasTheSameOne) {
  run_eyes("run", "--set ball.present=false");
  ASSERT_EQ(saccade("detect " + at("run") + " --set radius_px=[4,14] --out " + at("again")).status, 0);
  for (const char* name : {"best", "paper_directed"}) {
    const Json run = json_in("run/metrics.json")["detectors"][name];
    const Json again = json_in("again/metrics.json")["detectors"][name];
    ASSERT_TRUE(run["alarm_ratio"].is_number()) << name;
    EXPECT_NEAR(again["alarm_ratio"].get<double>(), run["alarm_ratio"].get<double>(), 0.02) << name;
    EXPECT_EQ(run["chances"], 0);
    EXPECT_TRUE(run["average_precision"].is_null());
  }
}

TEST_F(Scores, AreTheSameBytesInFiguresJsonFromRunToRun) {
  run_eyes("a");
  run_eyes("b", "--set run.threads=1");
  const std::string figures = bytes_of(folder_ / "a/figures.json");
  EXPECT_GT(figures.size(), 1000U);
  EXPECT_EQ(figures, bytes_of(folder_ / "b/figures.json"));
  EXPECT_THAT(figures, Not(HasSubstr("wall_s")));
  EXPECT_NE(bytes_of(folder_ / "a/metrics.json"), bytes_of(folder_ / "b/metrics.json")) << "wall-clock time";
  ASSERT_EQ(saccade("detect " + at("a") + " --out " + at("c")).status, 0);
  ASSERT_EQ(saccade("detect " + at("b") + " --out " + at("d")).status, 0);
  Json c = json_in("c/figures.json");
  Json d = json_in("d/figures.json");
  for (Json* json : {&c, &d}) json->erase("scenario");  // the names of the folders
  EXPECT_EQ(c, d);
}

TEST_F(Scores, ByEventTimeOfARunAreThoseOfItsRecordedEventsAndStreamingOnesAreLower) {
  run_eyes("late",
           "--set render.method=direct --set render.max_interval_ms=5 --set render.max_displacement_px=0.5");
  const Json run = json_in("late/metrics.json")["detectors"]["paper_directed"];
  ASSERT_EQ(saccade("detect " + at("late") + " --set radius_px=[4,14] --out " + at("replayed")).status, 0);
  const Json replayed = json_in("replayed/metrics.json")["detectors"]["paper_directed"];
  EXPECT_NEAR(run["average_precision"].get<double>(), replayed["average_precision"].get<double>(), 0.02);
  EXPECT_LT(run["streaming"]["average_precision"].get<double>(), run["average_precision"].get<double>());
  EXPECT_EQ(replayed["streaming"]["average_precision"], replayed["average_precision"]);
  const auto rows = read_table<StreamingRow>(folder_ / "late/streaming.csv");
  ASSERT_GT(rows.size(), 100U);
  for (const StreamingRow& row : rows) ASSERT_LE(row.ready_us, row.t_us);
}

TEST_F(Scores, WithoutLateEventsAreTheSameByEventTimeAndStreaming) {
  run_eyes("run");
  const Json run = json_in("run/metrics.json")["detectors"];
  ASSERT_GE(run.size(), 2U);
  for (const auto& [name, detector] : run.items()) {
    if (name == "frame_30hz") continue;  // by event time only the instants of its images count
    for (const char* key : {"average_precision", "precision", "recall"})
      EXPECT_EQ(detector["streaming"][key], detector[key]) << name << ' ' << key;
    EXPECT_EQ(detector["streaming"]["latency_ms"]["p99"], 0.0) << name;
  }
}

TEST_F(Scores, OfARecordingWithTheJointsOfItsRunAreThoseOfTheRunFolder) {
  run_eyes("run");
  const auto detect = [&](const std::string& options, const std::string& name) {
    const Outcome outcome = saccade("detect " + options + " --set radius_px=[4,14] --out " + at(name));
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    return bytes_of(folder_ / name / "detections.csv");
  };
  const std::string bare = at("run/events.aedat") + " --truth " + at("run/truth.csv");
  const std::string own = detect(at("run"), "own");
  EXPECT_NE(detect(bare, "bare"), own) << "best uses the motion of the camera";
  folder_.write("calibration.yaml",
                "calibration: " + json_in("run/metrics.json")["calibration"].dump() + "\n");
  const std::string known = bare + " --calibration " + at("calibration.yaml") + " --joints ";
  detect(known + at("run/joints.csv"), "table");
  // The same joints as a data dumper logs them.
  std::ofstream log(folder_ / "data.log");
  log.precision(17);
  int number = 0;
  for (const JointsRow& row : read_table<JointsRow>(folder_ / "run/joints.csv")) {
    log << number++ << ' ' << std::fixed << static_cast<double>(row.t_us) * 1e-6;
    for (int j = 3; j < joint_count; ++j) log << ' ' << row.position_rad[j] * 180.0 / M_PI;
    log << '\n';
  }
  log.close();
  detect(known + at("data.log"), "log");
  EXPECT_NEAR(json_in("log/metrics.json")["detectors"]["best"]["average_precision"].get<double>(),
              json_in("table/metrics.json")["detectors"]["best"]["average_precision"].get<double>(), 1e-3);
}

TEST_F(Scores, OfARecordingWithJointsOfAnotherTimeAreRejectedWithBothTimes) {
  write_noise("noise.aedat");
  folder_.write("early.log", "0 0.1 1 2 3 4 5 6\n1 0.2 1 2 3 4 5 6\n");
  folder_.write("late.log", "0 50.0 1 2 3 4 5 6\n1 50.1 1 2 3 4 5 6\n");
  folder_.write("none.log", "0 1.0\n");
  const auto refused = [&](const std::string& joints, const std::string& message) {
    const Outcome outcome = saccade("detect " + at("noise.aedat") + " --joints " + joints);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_THAT(outcome.text, HasSubstr(message));
  };
  refused(at("early.log"), "joints from 0.100000 to 0.200000 s, before the first event at 1.000000 s");
  refused(at("late.log"), "joints from 50.000 s on, after the last event");
  refused(at("none.log"), "none.log:1: found 0 1.0, expected the number of a packet");
  refused(at("missing.csv"), "missing.csv: found No such file");
}

}  // namespace
}  // namespace saccade
