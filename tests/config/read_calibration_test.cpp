// What a scenario believes of its camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config/cameras.h"
#include "config/scenario.h"
#include "head/icub_cameras.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const char* const measured = R"(calibration:
  {width_px: 128, height_px: 128, fx_px: 101, fy_px: 102, cx_px: 60, cy_px: 61, k1: -0.1, k2: 0, p1: 0, p2: 0,
   eye_from_camera: {translation_mm: [1, -2, -10], rotation_deg: [0.5, -1, 1.5]}}
)";

class ReadCalibration : public testing::Test {
 protected:
  [[nodiscard]] Scenario read(const std::string& block,
                              const std::vector<std::string>& assignments = {}) const {
    write("scene.yaml",
          "name: a\nrun: {duration_s: 1}\nball: {trajectory: {kind: hold}}\n"
          "detectors: {paper_full: {}}\ngaze: {detector: none}\n" +
              block);
    return read_scenario(folder_ / "scene.yaml", assignments, std::nullopt, built_in());
  }
  [[nodiscard]] std::string message(const std::string& block,
                                    const std::vector<std::string>& assignments = {}) const {
    try {
      static_cast<void>(read(block, assignments));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  TempFolder folder_;
};

TEST_F(ReadCalibration, BelievesByDefaultWhatIsSo) {
  const Scenario scenario = read(
      "camera: {fx_px: 90, k1: 0, eye_from_camera: {translation_mm: [0, 0, -10]}}\n", {"camera.cy_px=66"});
  EXPECT_EQ(scenario.sim.camera.fx_px, 90.0);
  EXPECT_EQ(scenario.sim.mount.translation_mm[2], -10.0);
  EXPECT_EQ(scenario.calibration, (MountedCamera{scenario.sim.camera, scenario.sim.mount}));
}

TEST_F(ReadCalibration, AnErrorIsAKeyAndTheCameraStaysWhatItIs) {
  const Scenario scenario =
      read("", {"calibration.fx_px=101", "calibration.eye_from_camera.rotation_deg=[0, 1, 0]"});
  EXPECT_EQ(scenario.sim.camera, icub_left_2016);
  EXPECT_EQ(scenario.sim.mount, CameraMount{});
  EXPECT_EQ(scenario.calibration.camera.fx_px, 101.0);
  EXPECT_EQ(scenario.calibration.camera.fy_px, icub_left_2016.fy_px);
  EXPECT_EQ(scenario.calibration.mount.rotation_deg[1], 1.0);
}

TEST_F(ReadCalibration, AFileIsWhereItsKeysStartFrom) {
  write("left.yaml", measured);
  const Scenario scenario = read("calibration: {file: left.yaml, fy_px: 103}\n");
  EXPECT_EQ(scenario.calibration.camera.fx_px, 101.0);
  EXPECT_EQ(scenario.calibration.camera.fy_px, 103.0);
  EXPECT_EQ(scenario.calibration.mount.translation_mm[1], -2.0);
  EXPECT_EQ(scenario.sim.camera, icub_left_2016);
  const std::string by_hand = "calibration.file=" + (folder_ / "left.yaml").string();
  EXPECT_EQ(read("", {by_hand, "calibration.fy_px=103"}).calibration, scenario.calibration);
}

TEST_F(ReadCalibration, AFisheyeThatWasCalibratedIsRead) {
  Calibration calibration;
  calibration.camera.camera = camera_preset("davis346");
  calibration.camera.mount.translation_mm = {1.0, -2.0, -10.0};
  calibration.deviations.k3 = 0.25;
  const std::string text = calibration_yaml(calibration);
  EXPECT_THAT(text, AllOf(HasSubstr("lens: fisheye"), HasSubstr("k3: 0.25")));
  write("fisheye.yaml", text);
  EXPECT_EQ(read("camera: {preset: davis346}\ncalibration: {file: fisheye.yaml}\n").calibration,
            calibration.camera);
  const std::size_t k4 = text.find("\n  k4: ");
  ASSERT_NE(k4, std::string::npos) << text;
  write("half.yaml", text.substr(0, k4) + text.substr(text.find('\n', k4 + 1)));
  EXPECT_THAT(message("camera: {preset: davis346}\ncalibration: {file: half.yaml}\n"),
              AllOf(HasSubstr("half.yaml"), HasSubstr("calibration.k4")));
}

TEST_F(ReadCalibration, TheResolvedScenarioNeedsNoFile) {
  write("left.yaml", measured);
  const Scenario scenario = read("calibration: {file: left.yaml}\n");
  std::filesystem::remove(folder_ / "left.yaml");
  write("resolved.yaml", resolved_scenario(scenario));
  EXPECT_EQ(read_scenario(folder_ / "resolved.yaml", {}, std::nullopt, built_in()).calibration,
            scenario.calibration);
}

TEST_F(ReadCalibration, RejectsWhatIsNoCalibrationOfThisCamera) {
  write("half.yaml", "calibration: {width_px: 128, height_px: 128, fx_px: 101}\n");
  EXPECT_THAT(message("calibration: {file: half.yaml}\n"),
              AllOf(HasSubstr("half.yaml"), HasSubstr("calibration.cx_px")));
  EXPECT_THAT(message("calibration: {file: gone.yaml}\n"), HasSubstr("gone.yaml"));
  EXPECT_THAT(message("calibration: {file: [1, 2]}\n"),
              HasSubstr("scene.yaml:6: calibration.file: found a list"));
  EXPECT_THAT(message("", {"calibration.width_px=64"}),
              HasSubstr("calibration.width_px: found 64 x 128 pixels"));
  EXPECT_THAT(message("calibration: {fx: 101}\n"), HasSubstr("did you mean"));
}

}  // namespace
}  // namespace saccade
