// Defaults that follow other keys, presets of cameras, names, and warnings of what is implausible.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/config/cameras.h"
#include "apps/config/scenario.h"
#include "apps/config/warnings.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ScenarioDefaults : public testing::Test {
 protected:
  [[nodiscard]] Scenario read(const std::vector<std::string>& assignments = {}) const {
    const auto path = folder_.write("scene.yaml",
                                    "name: a\nrun: {duration_s: 1}\n"
                                    "ball: {trajectory: {kind: hold, points_m: [[-0.5, 0, 0.347]]}}\n"
                                    "detectors: {best: {}}\ngaze: {detector: none}\n");
    return read_scenario(path, assignments, std::nullopt, built_in());
  }
  [[nodiscard]] std::string message(const std::vector<std::string>& assignments) const {
    try {
      static_cast<void>(read(assignments));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  TempFolder folder_;
};

TEST_F(ScenarioDefaults, TheCameraIsTheLeftOneOfTheICubOf2016) {
  const Scenario scenario = read();
  EXPECT_EQ(scenario.camera_preset, "icub_left_2016");
  EXPECT_EQ(scenario.sim.camera, camera_preset("icub_left_2016"));
  EXPECT_EQ(read({"eyes=both"}).sim.right.camera, camera_preset("icub_right_2016"));
  EXPECT_EQ(read({"camera.preset=icub_right_2016"}).sim.camera, camera_preset("icub_right_2016"));
  EXPECT_EQ(read({"camera.preset=icub_right_2016", "camera.k1=0"}).sim.camera.k1, 0.0);
}

TEST_F(ScenarioDefaults, AnImageSizeOfOnesOwnBringsAPinholeOfThatSize) {
  const Scenario scenario = read({"camera.width_px=346", "camera.height_px=260", "emulator.preset=davis346",
                                  "eyes=both", "output.events=csv"});
  EXPECT_EQ(scenario.camera_preset, "pinhole");
  EXPECT_EQ(scenario.sim.camera, pinhole_camera({346, 260}));
  EXPECT_EQ(scenario.sim.camera.cx_px, 172.5);
  EXPECT_FALSE(scenario.sim.camera.has_lens());
  EXPECT_NEAR(scenario.sim.camera.fx_px, 268.8, 0.1);
  EXPECT_EQ(scenario.calibration.camera, scenario.sim.camera);
  EXPECT_EQ(scenario.sim.right.camera, scenario.sim.camera);
  EXPECT_EQ(read({"camera.width_px=346", "camera.fx_px=300"}).sim.camera.fx_px, 300.0);
}

TEST_F(ScenarioDefaults, APresetAndAnotherImageSizeContradictEachOther) {
  EXPECT_THAT(
      message({"camera.preset=icub_left_2016", "camera.width_px=346"}),
      HasSubstr(
          "camera.width_px: found 346 x 128 pixels, expected 128 x 128 pixels, the image of the preset"));
  EXPECT_EQ(read({"camera.preset=pinhole", "camera.width_px=346"}).sim.camera, pinhole_camera({346, 128}));
}

TEST_F(ScenarioDefaults, TheResolvedScenarioHasTheSameCameras) {
  for (const auto& sets : {std::vector<std::string>{"camera.width_px=346", "camera.fx_px=300"},
                           {"camera.preset=icub_right_2016", "camera.cy_px=60"},
                           {"eyes=both"}}) {
    const Scenario scenario = read(sets);
    const std::string resolved = resolved_scenario(scenario);
    const Scenario again =
        read_scenario(folder_.write("resolved.yaml", resolved), {}, std::nullopt, built_in());
    EXPECT_EQ(resolved_scenario(again), resolved);
    EXPECT_EQ(again.sim.camera, scenario.sim.camera);
  }
}

TEST_F(ScenarioDefaults, TheGateAssumesTheBallOfTheScenario) {
  EXPECT_EQ(read({"ball.diameter_m=0.06"}).gaze.gate.target.ball_diameter_m, 0.06);
  EXPECT_EQ(
      read({"ball.diameter_m=0.06", "gaze.target.ball_diameter_m=0.07"}).gaze.gate.target.ball_diameter_m,
      0.07);
  EXPECT_EQ(read().gaze.gate.target.ball_diameter_m, 0.095);
}

TEST_F(ScenarioDefaults, ANameThatIsNoFolderIsRejected) {
  for (const char* name : {"../../evil", "/tmp/evil", "..", ".hidden", "a\\b"}) {
    EXPECT_THAT(message({"name='" + std::string(name) + "'"}),
                AllOf(HasSubstr("name: found "), HasSubstr("expected the name of a folder"),
                      testing::Not(HasSubstr("\n"))))
        << name;
  }
  EXPECT_EQ(message({"name=a ball at 0.5 m"}), "accepted");
}

TEST_F(ScenarioDefaults, ADetectorsNameHasNoCommaAndNoDot) {
  for (const char* name : {"a,b", "a/b", "../a"}) {
    EXPECT_THAT(message({"detectors={'" + std::string(name) + "': {preset: best}}"}),
                AllOf(HasSubstr("detectors." + std::string(name) + ": found such a name"),
                      HasSubstr("letters, digits, _ and -")));
  }
  EXPECT_THAT(message({"detectors={a.b: {preset: best}, a_b: {preset: best}}"}),
              HasSubstr("detectors.a.b: found such a name"));
}

TEST_F(ScenarioDefaults, NothingOfAPlausibleScenarioIsWarnedOf) {
  EXPECT_THAT(warnings_of(read()), IsEmpty());
  EXPECT_THAT(warnings_of(read({"camera.width_px=346", "camera.height_px=260"})), IsEmpty());
}

TEST_F(ScenarioDefaults, ACentreOutsideTheImageIsWarnedOf) {
  EXPECT_THAT(warnings_of(read({"camera.cx_px=130"})),
              testing::Contains(
                  HasSubstr("camera: the principal point (130, 69.18) lies outside the image of 128 x 128")));
}

TEST_F(ScenarioDefaults, ALensOfAnotherImageIsWarnedOf) {
  EXPECT_THAT(warnings_of(read({"camera.width_px=346", "camera.height_px=260", "camera.fx_px=60",
                                "camera.fy_px=60", "camera.k1=-0.2", "camera.k2=0.74"})),
              testing::Contains(HasSubstr("camera: the lens moves a point of the image by")));
}

TEST_F(ScenarioDefaults, ABallThatNoRadiusFitsIsWarnedOf) {
  EXPECT_THAT(warnings_of(read({"ball.diameter_m=0.03"})),
              ElementsAre(AllOf(HasSubstr("detectors.best.radius_px: the ball's radius in the image is "),
                                HasSubstr("never in [10, 35]"))));
}

}  // namespace
}  // namespace saccade
