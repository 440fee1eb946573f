// Programs with a detector or a gaze controller of their own, built from examples/.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

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
  EXPECT_THAT(run.text, HasSubstr("blob_filter, centroid"));
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

}  // namespace
}  // namespace saccade
