// Programs with a row of their own in a registry, built from examples/.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string scenario = " '" SACCADE_SOURCE_DIR "/scenarios/look_at_ball.yaml' ";
/// A ball alone before a plain wall, for a short time.
const std::string short_run =
    " --set run.duration_s=0.6 --set ball.trajectory.start_s=0 --set lab.density=0 --set expect={} "
    "--set output.pictures=0 ";

Outcome with_detector(const std::string& arguments) {
  return run_shell("'" SACCADE_DETECTOR_EXAMPLE "' " + arguments);
}
Outcome with_controller(const std::string& arguments) {
  return run_shell("'" SACCADE_CONTROLLER_EXAMPLE "' " + arguments);
}

Outcome with_format(const std::string& arguments) {
  return run_shell("'" SACCADE_FORMAT_EXAMPLE "' " + arguments);
}
Outcome with_backend(const std::string& arguments) {
  return run_shell("'" SACCADE_BACKEND_EXAMPLE "' " + arguments);
}

class OwnProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string out(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] nlohmann::json metrics(const std::string& name) const {
    return nlohmann::json::parse(bytes_of(folder_ / name / "metrics.json"));
  }

  TempFolder folder_;
};

TEST_F(OwnProgram, RunsADetectorOfItsOwnInAScenarioAndOnARecording) {
  const Outcome run =
      with_detector("run" + scenario + short_run +
                    "--set 'detectors={centroid: {events: 200}}' --set gaze.detector=centroid "
                    "--out " +
                    out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  EXPECT_THAT(bytes_of(folder_ / "run/detections.csv"), HasSubstr(",centroid,"));
  EXPECT_TRUE(metrics("run")["detectors"]["centroid"]["average_precision"].is_number());
  EXPECT_EQ(metrics("run")["gaze"]["detector"], "centroid");
  EXPECT_EQ(metrics("run")["gaze"]["window"], "200 events");
  EXPECT_THAT(bytes_of(folder_ / "run/report.html"), HasSubstr("centroid"));

  const std::string detectors =
      folder_.write("detectors.yaml", "detectors: {centroid: {}, best: {}}\n").string();
  const Outcome detect = with_detector("detect '" + out("run") + "' --config '" + detectors +
                                       "' --set centroid.events=100 --out " + out("detect"));
  ASSERT_EQ(detect.status, 0) << detect.text;
  EXPECT_THAT(detect.text, HasSubstr("centroid"));
  EXPECT_THAT(bytes_of(folder_ / "detect/detections.csv"), HasSubstr(",centroid,"));
  EXPECT_THAT(bytes_of(folder_ / "detect/detectors.yaml"), HasSubstr("events: 100"));
}

TEST_F(OwnProgram, SweepsWithADetectorOfItsOwn) {
  const std::string file =
      folder_
          .write("sweep.yaml", "name: own\nscenario: " SACCADE_SOURCE_DIR
                               "/scenarios/look_at_ball.yaml\n"
                               "set: {run.duration_s: 0.3, lab.density: 0, detectors: {centroid: {}}, "
                               "gaze.detector: none}\n"
                               "axes:\n  detectors.centroid.events: [100, 200]\nreport: {worst: 0}\n")
          .string();
  const Outcome sweep =
      with_detector("sweep '" + file + "' --out " + out("sweep") + " --csv " + out("sweep.csv"));
  ASSERT_EQ(sweep.status, 0) << sweep.text;
  EXPECT_THAT(sweep.text, HasSubstr("2 runs done, 0 failed"));
  EXPECT_THAT(bytes_of(folder_ / "sweep.csv"), HasSubstr("detectors.centroid.average_precision"));
}

TEST_F(OwnProgram, ListsADetectorOfItsOwnWhereAPresetIsUnknown) {
  const Outcome run = with_detector("run" + scenario + "--set detectors.mine.preset=mine");
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.text, HasSubstr("socket, centroid"));
}

TEST_F(OwnProgram, MovesTheHeadWithAGazeControllerOfItsOwn) {
  const Outcome run =
      with_controller("run" + scenario +
                      "--set gaze.controller=proportional --set gaze.proportional.gain_per_s=10 "
                      "--set expect={} --set output.pictures=0 --out " +
                      out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  const nlohmann::json gaze = metrics("run")["gaze"];
  EXPECT_EQ(gaze["controller"], "proportional");
  // The few targets of a short run keep the ball in view; the example controller lags behind it.
  EXPECT_GT(gaze["in_view_ratio"].get<double>(), 0.9);
  EXPECT_GT(gaze["moves"].get<int>(), 0);
  EXPECT_EQ(gaze["limit_violations"], 0);
  EXPECT_THAT(bytes_of(folder_ / "run/scenario.yaml"), HasSubstr("gain_per_s: 10"));
}

TEST_F(OwnProgram, WritesAndReadsAFormatOfItsOwnInEverySubcommand) {
  const Outcome run =
      with_format("run" + scenario + short_run + "--set output.events=packed --out " + out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  EXPECT_EQ(metrics("run")["events"]["file"], "events.packed");
  EXPECT_THAT(bytes_of(folder_ / "run/events.packed"), testing::StartsWith("PACKED1\n"));
  EXPECT_THAT(bytes_of(folder_ / "run/report.html"),
              Not(HasSubstr("expected a recording in a known format")));

  const Outcome detect = with_format("detect '" + out("run") + "' --out " + out("detect"));
  ASSERT_EQ(detect.status, 0) << detect.text;
  // All but those before the first row of joints.
  EXPECT_GT(metrics("detect")["events"]["count"].get<double>(),
            0.99 * metrics("run")["events"]["count"].get<double>());
  const Outcome report =
      with_format("report '" + out("run") + "' '" + out("detect") + "' --out " + out("report"));
  EXPECT_EQ(report.status, 0) << report.text;
  const Outcome convert = with_format("convert '" + out("run") + "' " + out("copy.aedat4"));
  EXPECT_EQ(convert.status, 0) << convert.text;
  const Outcome again = with_format("run" + scenario + short_run + "--force --out " + out("run"));
  ASSERT_EQ(again.status, 0) << again.text;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run/events.packed"));
}

TEST_F(OwnProgram, DeploysARecordingInAFormatOfItsOwn) {
  const Outcome run =
      with_format("run" + scenario + short_run + "--set output.events=packed --out " + out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  const std::string robot =
      folder_
          .write("robot.yaml",
                 "name: again\nbackend: recording\nrecording: {path: run, speed: 4}\n"
                 "calibration: {width_px: 128, height_px: 128, fx_px: 99, fy_px: 99, cx_px: 64, cy_px: 64, "
                 "k1: 0, k2: "
                 "0, p1: 0, p2: 0}\ndetectors: {paper_full: {}}\noutput: {events: packed}\n")
          .string();
  const Outcome deploy = with_format("deploy '" + robot + "' --record --out " + out("deploy"));
  ASSERT_EQ(deploy.status, 0) << deploy.text;
  EXPECT_THAT(bytes_of(folder_ / "deploy/events.packed"), testing::StartsWith("PACKED1\n"));
}

TEST_F(OwnProgram, DeploysOnABackendOfItsOwn) {
  const Outcome deploy =
      with_backend("deploy '" SACCADE_SOURCE_DIR
                   "/examples/backend/robot.yaml' --activate --duration 0.5 --record "
                   // The machine may have other things to do.
                   "--set deploy.watchdog.safe_within_ms=1000 --set deploy.watchdog.tick_late_ms=490 "
                   "--set deploy.watchdog.camera_silent_ms=500 --set deploy.watchdog.joints_stale_ms=500 "
                   "--set deploy.watchdog.hang_ms=480 --out " +
                   out("deploy"));
  ASSERT_EQ(deploy.status, 0) << deploy.text;
  EXPECT_GT(metrics("deploy")["events"]["count"].get<int>(), 9'000);
  EXPECT_THAT(bytes_of(folder_ / "deploy/detections.csv"), HasSubstr(",paper_full,"));
  EXPECT_THAT(bytes_of(folder_ / "deploy/robot.yaml"), HasSubstr("turns_per_s: 1"));
  const Outcome unknown =
      with_backend("deploy '" SACCADE_SOURCE_DIR "/examples/backend/robot.yaml' --set backend=mine");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.text, HasSubstr("one of recording, yarp, practice, external, circle"));
  EXPECT_THAT(with_backend("keys robot").text, HasSubstr("circle.events_per_ms"));
}

}  // namespace
}  // namespace saccade
