#include "evaluation/scoring/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "evaluation/scoring/metric_reference.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;
using testing::ElementsAre;

Metrics whole() {
  Metrics m;
  m.scenario = "gaze_square_45cm \"quoted\"";
  m.seed = 3;
  m.settings = {{"lab.clutter", "rectilinear"}, {"ball.diameter_m", "0.07"}};
  m.start_us = 5;
  m.duration_s = 4.0;
  m.wall_s = 3.2;
  m.event_count = 1000;
  m.events_dropped = 2;
  m.events_file = "events.aedat";
  m.image = {128, 128};
  m.camera = icub_left_2016;
  m.calibration = MountedCamera{icub_left_2016.without_lens(), {{0.0, 0.0, -10.0}, {0.5, -1.0, 1.5}}};
  DetectorScore score;
  score.average_precision = 1.0 / 3.0;
  score.precision_at_recall[1] = 0.75;
  score.pr_curve = {{0.5, 0.9, 0.1}, {0.4, 0.8, 0.2}};
  score.chances = 4000;
  score.threshold = 0.45;
  score.observations = 900;
  score.inliers = 800;
  score.precision = 0.8;
  score.recall = 0.2;
  score.mean_rate_hz = 200.0;
  score.peak_rate_hz = 550.0;
  score.position_error_px = {1.5, 4.5};
  score.radius_error_px = {0.5, 1.5};
  score.lag_ms = 12.3;
  score.us_per_event = 0.4;
  score.rejected_events = {.outside_image = 7, .back_in_time = 2};
  score.alarm_ratio = 0.02;
  score.alarms_per_min = 6.0;
  score.nees = Nees{700, 0.91, 2.4};
  score.reliability.emplace();
  score.reliability->at(9) = {3, 2, 0.1 + 0.2 + 0.65};
  score.streaming = StreamingScore{0.5, 0.6, 0.1, 0.0, 4.0};
  m.detectors = {{"paper_full", {}}, {"best", score}};
  m.gaze.emplace();
  m.gaze->detector = "best";
  m.gaze->controller = "qp";
  m.gaze->window = "1500 events";
  m.gaze->following_rate_hz = 12.5;
  m.gaze->score = {.acquire_within_deg = 6.0,
                   .acquire_s = 0.75,
                   .acquired_at_us = 1'250'000,
                   .fixation_error_deg = {2.0, 5.0},
                   .on_target_ratio = 0.9,
                   .in_view_ratio = 1.0,
                   .moves = 10,
                   .wrong_moves = 1,
                   .saccades = 3,
                   .limit_violations = 4,
                   .target_error_median_m = 0.01};
  m.gaze->limits.min_rad.setConstant(-0.5);
  m.gaze->limits.max_rad.setConstant(0.25);
  RightEyeMetrics& right = m.right_eye.emplace();
  right.event_count = 400;
  right.events_dropped = 1;
  right.camera = icub_right_2016;
  right.calibration.camera = icub_right_2016;
  right.calibration.mount.rotation_deg = {0.5, -1.0, 1.0};
  right.fixation_error_deg = {1.5, 3.0};
  right.on_target_ratio = 0.8;
  right.in_view_ratio = 0.9;
  right.detectors = {{"best", score}};
  return m;
}

std::vector<std::string> keys(const Json& json) {
  std::vector<std::string> names;
  for (const auto& item : json.items()) names.push_back(item.key());
  return names;
}

TEST(Metrics, WarnWhereACameraDroppedMoreThanAHundredthOfItsEvents) {
  Metrics metrics = whole();
  EXPECT_EQ(dropped_warning(metrics), "");
  metrics.events_dropped = 6;  // of 606
  EXPECT_EQ(dropped_warning(metrics), "");
  metrics.events_dropped = 60;
  EXPECT_THAT(dropped_warning(metrics),
              testing::StartsWith("the left event camera dropped 9.1 % of its events: "));
  metrics.right_eye->events_dropped = 100;
  EXPECT_THAT(dropped_warning(metrics), testing::HasSubstr("; the right event camera dropped 20.0 %"));
  metrics.right_eye.reset();
  metrics.events_dropped = 20;
  EXPECT_THAT(dropped_warning(metrics),
              testing::StartsWith("the event camera dropped 2.0 % of its events: "));
  metrics.events_dropped = std::nullopt;
  EXPECT_EQ(dropped_warning(metrics), "");
  EXPECT_EQ(dropped_share(metrics), std::nullopt);
}

TEST(Metrics, HasEveryKeyOfTheContractInItsOrder) {
  const Json json = Json::parse(metrics_to_json(whole()));
  EXPECT_THAT(keys(json), ElementsAre("schema", "scenario", "seed", "duration_s", "wall_s",
                                      "real_time_factor", "interrupted", "events", "detectors", "gaze",
                                      "camera", "start_us", "settings", "calibration", "right_eye"));
  EXPECT_THAT(keys(json["events"]), ElementsAre("count", "rate_hz", "dropped", "file", "dropped_share"));
  EXPECT_DOUBLE_EQ(json["events"]["dropped_share"].get<double>(),
                   2.0 / 602.0);  // without those of the right eye
  EXPECT_DOUBLE_EQ(json["right_eye"]["events"]["dropped_share"].get<double>(), 1.0 / 401.0);
  EXPECT_THAT(keys(json["detectors"]), ElementsAre("paper_full", "best"));
  for (const auto& detector : json["detectors"]) {
    EXPECT_THAT(keys(detector), ElementsAre("average_precision", "precision_at_recall", "pr_curve", "chances",
                                            "threshold", "precision", "recall", "detection_rate_hz",
                                            "position_error_px", "radius_error_px", "lag_ms", "us_per_event",
                                            "alarm_ratio", "alarms_per_min", "streaming", "nees",
                                            "reliability", "observations", "inliers", "rejected_events"));
    EXPECT_THAT(keys(detector["precision_at_recall"]), ElementsAre("0.1", "0.2", "0.3", "0.5", "0.7", "0.9"));
    EXPECT_THAT(keys(detector["detection_rate_hz"]), ElementsAre("mean", "peak"));
    EXPECT_THAT(keys(detector["position_error_px"]), ElementsAre("median", "p95"));
    EXPECT_THAT(keys(detector["radius_error_px"]), ElementsAre("median", "p95"));
  }
  EXPECT_THAT(keys(json["detectors"]["best"]["pr_curve"][0]),
              ElementsAre("threshold", "precision", "recall"));
  EXPECT_THAT(
      keys(json["gaze"]),
      ElementsAre("detector", "fixation_error_deg", "on_target_ratio", "in_view_ratio", "acquire_s", "moves",
                  "wrong_moves", "saccades", "limit_violations", "target_error_m", "acquire_within_deg",
                  "joint_limits_rad", "controller", "gate", "window", "acquired_at_us", "following_rate_hz"));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["real_time_factor"], 1.25);
  EXPECT_EQ(json["events"]["rate_hz"], 250.0);
}

/// The paths of everything in a block that is no block itself, with NAME for that of a detector.
void add_paths(const Json& json, const std::string& path, std::vector<std::string>& paths) {
  if (!json.is_object() || json.empty()) {
    paths.push_back(path);
    return;
  }
  const bool names = path == "detectors" || path == "latency.detectors";
  for (const auto& [key, value] : json.items())
    add_paths(value, (path.empty() ? "" : path + ".") + (names ? "NAME" : key), paths);
}

TEST(Metrics, AreAllInTheReferenceWhichHasNothingElse) {
  // With all that is written only where it applies.
  Metrics metrics = whole();
  metrics.events_camera = 1;
  metrics.controller_failure = "ended";
  metrics.files = {{"robot.file", "robot.xml", "00"}};
  metrics.clutter = ClutterShare{.share = 0.5, .by_object = {{"hand", 0.5}}, .by_cause = {{"shot", 0.1}}};
  metrics.latency = LatencyMetrics{"model", {{"best", 0.5, 3}}};
  DetectorScore& best = metrics.detectors[1].second;
  best.exact = false;
  best.streaming->exact = false;
  best.failure = "ended";
  best.clutter.emplace();
  metrics.gaze->score.exact = false;
  metrics.gaze->failure = "ended";
  metrics.gaze->eye_movements.emplace();
  std::vector<std::string> paths;
  add_paths(Json::parse(metrics_to_json(metrics)), "", paths);
  const auto covers = [](std::string_view row, const std::string& path) {
    return path == row || path.starts_with(std::string(row) + ".");
  };
  for (const std::string& path : paths) {
    if (path == "detectors.NAME.streaming") continue;  // null, of the detector without figures
    EXPECT_TRUE(
        std::ranges::any_of(metric_reference(), [&](const MetricRow& row) { return covers(row.path, path); }))
        << path << " has no row";
  }
  for (const MetricRow& row : metric_reference()) {
    EXPECT_TRUE(std::ranges::any_of(paths, [&](const std::string& path) { return covers(row.path, path); }))
        << row.path << " is not in metrics.json";
    EXPECT_FALSE(row.type.empty() || row.doc.empty()) << row.path;
  }
}

TEST(Metrics, OfADetectorHaveStreamingReliabilityAndNees) {
  const Json best = Json::parse(metrics_to_json(whole()))["detectors"]["best"];
  EXPECT_EQ(best["alarm_ratio"], 0.02);
  EXPECT_THAT(keys(best["streaming"]), ElementsAre("average_precision", "precision", "recall", "latency_ms"));
  EXPECT_EQ(best["streaming"]["latency_ms"]["p99"], 4.0);
  EXPECT_EQ(best["nees"]["share"], 0.91);
  ASSERT_EQ(best["reliability"].size(), 10U);
  EXPECT_EQ(best["reliability"][9]["from"], 0.9);
  EXPECT_EQ(best["reliability"][9]["inlier_share"], 2.0 / 3.0);
  EXPECT_TRUE(best["reliability"][0]["inlier_share"].is_null());
}

TEST(Metrics, WithoutAThresholdHaveNoCountsAtIt) {
  Metrics m = whole();
  m.detectors[1].second.threshold = std::numeric_limits<double>::quiet_NaN();
  const std::string text = metrics_to_json(m);
  for (const char* key : {"threshold", "observations", "inliers"})
    EXPECT_TRUE(Json::parse(text)["detectors"]["best"][key].is_null()) << key;
  EXPECT_EQ(metrics_to_json(metrics_from_json(text, "here")), text);
}

TEST(Metrics, FiguresAreTheSameWhateverTheClockMeasuredAndWhereverTheEventsLie) {
  Metrics slow = whole();
  slow.wall_s = 9.0;
  slow.events_file = "/somewhere/else/events.aedat";
  for (auto* detectors : {&slow.detectors, &slow.right_eye->detectors}) {
    for (auto& [name, score] : *detectors) score.us_per_event = 7.0;
  }
  EXPECT_EQ(figures_to_json(slow), figures_to_json(whole()));
  Json json = Json::parse(metrics_to_json(whole()));
  for (const char* key : {"wall_s", "real_time_factor"}) json.erase(key);
  for (auto* detectors : {&json["detectors"], &json["right_eye"]["detectors"]}) {
    for (Json& detector : *detectors) detector.erase("us_per_event");
  }
  EXPECT_EQ(Json::parse(figures_to_json(whole())), json) << "everything else is there";
}

TEST(Metrics, ListTheFilesThatTheRunReadInFiguresByTheirNames) {
  Metrics m = whole();
  m.interrupted = true;
  m.files = {{"detectors.mine.python", "/home/me/mine.py", "0123456789abcdef", false}};
  const Json json = Json::parse(metrics_to_json(m));
  EXPECT_EQ(json["interrupted"], true);
  EXPECT_EQ(json["files"][0]["file"], "/home/me/mine.py");
  EXPECT_EQ(metrics_to_json(metrics_from_json(json.dump(), "here")), metrics_to_json(m));
  const Json figures = Json::parse(figures_to_json(m));
  EXPECT_EQ(figures["interrupted"], true);
  EXPECT_THAT(keys(figures["files"][0]), ElementsAre("key", "file", "digest"));
  EXPECT_EQ(figures["files"][0]["file"], "mine.py");
  EXPECT_EQ(figures["files"][0]["digest"], "0123456789abcdef");
}

TEST(Metrics, OfEarlierVersionsAreReadWithoutTheKeysThatWereAddedLater) {
  Json json = Json::parse(metrics_to_json(whole()));
  for (const char* key : {"controller", "gate", "window", "acquired_at_us", "following_rate_hz"}) {
    json["gaze"].erase(key);
  }
  for (const char* key : {"alarm_ratio", "alarms_per_min", "streaming", "nees", "reliability"})
    json["detectors"]["best"].erase(key);
  json.erase("interrupted");
  const Metrics back = metrics_from_json(json.dump(), "here");
  EXPECT_EQ(back.gaze->controller, "");
  EXPECT_EQ(back.gaze->score.acquired_at_us, std::nullopt);
  EXPECT_EQ(back.gaze->following_rate_hz, std::nullopt);
  EXPECT_EQ(back.gaze->score.moves, 10);
}

TEST(Metrics, ReadsBackTheSame) {
  const std::string text = metrics_to_json(whole());
  const Metrics back = metrics_from_json(text, "here");
  EXPECT_EQ(metrics_to_json(back), text);
  EXPECT_EQ(back.detectors[1].second.lag_ms, 12.3);
  EXPECT_EQ(back.detectors[0].second.lag_ms, std::nullopt);
  EXPECT_EQ(back.gaze->score.acquire_s, 0.75);
  EXPECT_EQ(back.gaze->score.acquired_at_us, 1'250'000);
  EXPECT_EQ(back.gaze->controller, "qp");
  EXPECT_EQ(back.gaze->gate, "");
  EXPECT_TRUE(Json::parse(text)["gaze"]["gate"].is_null());
  EXPECT_EQ(back.gaze->window, "1500 events");
  EXPECT_EQ(back.gaze->following_rate_hz, 12.5);
  EXPECT_NEAR(back.gaze->limits.max_rad[eyes_tilt], 0.25, 1e-15);
  EXPECT_EQ(back.camera, icub_left_2016);
  EXPECT_EQ(back.calibration, whole().calibration);
  EXPECT_THAT(keys(Json::parse(text)["camera"]), ElementsAre("width_px", "height_px", "fx_px", "fy_px",
                                                             "cx_px", "cy_px", "k1", "k2", "p1", "p2"));
  EXPECT_EQ(back.settings, whole().settings);
  EXPECT_EQ(back.detectors[0].second.rejected_events.has_value(), false);
  EXPECT_EQ(back.detectors[1].second.rejected_events->outside_image, 7);
  EXPECT_EQ(back.detectors[1].second.rejected_events->back_in_time, 2);
}

TEST(Metrics, WritesFiguresThatDoNotApplyAsNull) {
  Metrics m;
  m.scenario = "recording.aedat";
  m.duration_s = std::numeric_limits<double>::quiet_NaN();
  m.detectors = {{"best", {}}};
  const std::string text = metrics_to_json(m);
  const Json json = Json::parse(text);
  for (const char* key : {"seed", "wall_s", "real_time_factor", "gaze", "duration_s"}) {
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  EXPECT_TRUE(json["events"]["rate_hz"].is_null());
  EXPECT_TRUE(json["events"]["dropped"].is_null());
  const Json& best = json["detectors"]["best"];
  EXPECT_TRUE(best["average_precision"].is_null());
  EXPECT_TRUE(best["precision_at_recall"]["0.9"].is_null());
  EXPECT_TRUE(best["detection_rate_hz"]["peak"].is_null());
  EXPECT_TRUE(best["lag_ms"].is_null());
  EXPECT_TRUE(best["rejected_events"].is_null());
  EXPECT_EQ(best["chances"], 0);
}

TEST(Metrics, WithoutDistortionHaveACameraWithoutALens) {
  Json json = Json::parse(metrics_to_json(whole()));
  for (const char* key : {"k1", "k2", "p1", "p2"}) json["camera"].erase(key);
  EXPECT_EQ(metrics_from_json(json.dump(), "here").camera, icub_left_2016.without_lens());
}

TEST(Metrics, WithoutSettingsAndRejectedEventsAreReadToo) {
  Json json = Json::parse(metrics_to_json(whole()));
  json.erase("settings");
  json.erase("calibration");
  json["detectors"]["best"].erase("rejected_events");
  const Metrics back = metrics_from_json(json.dump(), "here");
  EXPECT_TRUE(back.settings.empty());
  EXPECT_FALSE(back.detectors[1].second.rejected_events.has_value());
}

TEST(Metrics, OfARunWithLabelsHaveItsClutterAndReadBackTheSame) {
  Metrics m = whole();
  m.clutter = ClutterShare{0.75, {{"ball", 0.25}, {"background", 0.75}}, {{"signal", 1.0}}};
  m.detectors[0].second.clutter = DetectorClutter{0.5, std::nullopt, 12.0};
  const std::string text = metrics_to_json(m);
  const Json json = Json::parse(text);
  EXPECT_EQ(json["clutter"]["share"], 0.75);
  EXPECT_EQ(json["clutter"]["by_object"]["ball"], 0.25);
  EXPECT_EQ(json["clutter"]["by_cause"]["signal"], 1.0);
  EXPECT_EQ(json["detectors"]["paper_full"]["clutter_in_window"]["detected"], 0.5);
  EXPECT_TRUE(json["detectors"]["paper_full"]["clutter_in_window"]["missed"].is_null());
  EXPECT_EQ(json["detectors"]["paper_full"]["clutter_per_detection"], 12.0);
  EXPECT_FALSE(json["detectors"]["best"].contains("clutter_in_window"));
  EXPECT_EQ(metrics_to_json(metrics_from_json(text, "here")), text);
}

TEST(Metrics, NamesThePlaceOfAnError) {
  EXPECT_THROW(static_cast<void>(metrics_from_json("{", "here")), InputError);
  EXPECT_THROW(static_cast<void>(metrics_from_json("[]", "here")), InputError);
  Json json = Json::parse(metrics_to_json(whole()));
  json["schema"] = 2;
  EXPECT_THROW(static_cast<void>(metrics_from_json(json.dump(), "here")), InputError);
  json["schema"] = 1;
  json["detectors"]["best"].erase("lag_ms");
  try {
    static_cast<void>(metrics_from_json(json.dump(), "run/metrics.json"));
    FAIL() << "a missing key was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("run/metrics.json"), testing::HasSubstr("lag_ms")));
  }
  EXPECT_THROW(static_cast<void>(read_metrics("/nonexistent/metrics.json")), InputError);
}

}  // namespace
}  // namespace saccade
