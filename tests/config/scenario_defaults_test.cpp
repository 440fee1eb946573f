// Defaults that follow other keys, presets of cameras, names, and warnings of what is implausible.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/cameras.h"
#include "config/scenario.h"
#include "config/warnings.h"
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

TEST_F(ScenarioDefaults, NullRemovesASectionAndAKeyFromTheFile) {
  EXPECT_TRUE(read({"frame_30hz={}"}).frame_30hz.has_value());
  EXPECT_FALSE(read({"frame_30hz={}", "frame_30hz=null"}).frame_30hz.has_value());
  EXPECT_FALSE(read({"frame_30hz=null"}).frame_30hz.has_value()) << "there is none to remove";
  EXPECT_EQ(read({"ball.diameter_m=0.2", "ball.diameter_m=~"}).sim.world.ball.diameter_m,
            read().sim.world.ball.diameter_m);
  EXPECT_EQ(read({"detectors.paper_full={}", "detectors.best=null"}).detectors.size(), 1u);
  EXPECT_THAT(message({"name=null"}), HasSubstr("name: found no such key"));
  EXPECT_THAT(message({"frame_30z=null"}), HasSubstr("did you mean frame_30hz?"));
  EXPECT_THAT(message({"ball.diametre_m=null"}), HasSubstr("did you mean diameter_m?"));
  EXPECT_THAT(message({"seed="}), HasSubstr("seed: found nothing")) << "an empty value is a mistake";
}

TEST_F(ScenarioDefaults, TheBoundOfAcquisitionDoesNotDependOnTheNameOfTheDetector) {
  for (const char* detector : {"best", "paper_directed", "paper_full"}) {
    const std::string name = detector;
    EXPECT_EQ(read({"detectors." + name + "={}", "gaze.detector=" + name}).gaze.acquire_within_deg, 2.0)
        << name;
  }
  EXPECT_EQ(read({"gaze.acquire_within_deg=6"}).gaze.acquire_within_deg, 6.0);
  const Scenario shipped =
      read_scenario(SACCADE_SOURCE_DIR "/scenarios/look_at_ball.yaml", {}, std::nullopt, built_in());
  EXPECT_EQ(shipped.gaze.detector, "paper_directed");
  EXPECT_EQ(shipped.gaze.acquire_within_deg, 6.0);
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

TEST_F(ScenarioDefaults, APresetBringsImageSizeLensAndPixelsOfItsSensor) {
  struct Expected {
    const char* name;
    ImageSize size;
    double view_deg;
  };
  for (const auto& [name, size, view_deg] :
       {Expected{"dvs128", {128, 128}, 65.2}, Expected{"davis240", {240, 180}, 70.3},
        Expected{"davis346", {346, 260}, 90.9}, Expected{"gen3_vga", {640, 480}, 61.9},
        Expected{"gen4_hd", {1280, 720}, 63.8}}) {
    const Scenario scenario = read({std::string("camera.preset=") + name, "eyes=both"});
    EXPECT_EQ(scenario.sim.camera.size, size) << name;
    EXPECT_NEAR(field_of_view_deg(scenario.sim.camera), view_deg, 0.1) << name;
    EXPECT_EQ(scenario.sim.emulator.preset, name);
    EXPECT_EQ(scenario.sim.right.camera, scenario.sim.camera) << name;
    EXPECT_EQ(scenario.right_camera_preset, name);
    EXPECT_THAT(warnings_of(scenario), testing::Not(testing::Contains(HasSubstr("camera")))) << name;
  }
  EXPECT_EQ(read({"camera.preset=gen4_hd", "emulator.preset=noisy"}).sim.emulator.preset, "noisy");
  EXPECT_EQ(read({"camera.preset=gen4_hd", "emulator.latency_us=90"}).sim.emulator.latency_us, 90);
  EXPECT_EQ(read({"camera.preset=gen4_hd", "camera.cx_px=600"}).sim.camera.cx_px, 600.0);
}

TEST_F(ScenarioDefaults, ASmallerImageThanThePresetsIsTheMiddleOfItsSensor) {
  const Camera whole = read({"camera.preset=gen4_hd"}).sim.camera;
  const Camera part =
      read({"camera.preset=gen4_hd", "camera.width_px=640", "camera.height_px=360"}).sim.camera;
  EXPECT_EQ(part.fx_px, whole.fx_px);
  EXPECT_EQ(part.cx_px, 319.5);
  EXPECT_EQ(part.cy_px, 179.5);
  EXPECT_THAT(message({"camera.preset=davis346", "camera.width_px=640"}),
              HasSubstr("camera.width_px: found 640 x 260 pixels, expected at most 346 x 260 pixels"));
}

TEST_F(ScenarioDefaults, AFocalLengthMayBeGivenInMillimetresOrAsAFieldOfView) {
  EXPECT_NEAR(read({"camera.preset=gen3_vga", "camera.focal_mm=6"}).sim.camera.fy_px, 400.0, 1e-9);
  const Camera wide = read({"camera.preset=gen3_vga", "camera.field_of_view_deg=90"}).sim.camera;
  EXPECT_NEAR(wide.fx_px, 320.0, 1e-9);
  EXPECT_EQ(wide.fy_px, wide.fx_px);
  const Camera fisheye = read({"camera.width_px=346", "camera.height_px=260", "camera.lens=fisheye",
                               "camera.field_of_view_deg=120"})
                             .sim.camera;
  EXPECT_NEAR(field_of_view_deg(fisheye), 120.0, 1e-9);
  EXPECT_EQ(fisheye.k1, 0.0);
  const Camera lens = read({"camera.focal_mm=8"}).sim.camera;  // another lens than the iCub's
  EXPECT_NEAR(lens.fx_px, 200.0, 1e-9);
  EXPECT_FALSE(lens.has_lens());
  EXPECT_NEAR(
      read({"camera.width_px=640", "camera.height_px=480", "camera.pixel_pitch_um=15", "camera.focal_mm=8"})
          .sim.camera.fx_px,
      533.333, 1e-3);
}

TEST_F(ScenarioDefaults, NumbersOfACameraThatContradictEachOtherAreProblems) {
  EXPECT_THAT(
      message({"camera.preset=gen3_vga", "camera.focal_mm=8", "camera.field_of_view_deg=90"}),
      HasSubstr("camera.field_of_view_deg: found 90 (a focal length of 320 px), expected what focal_mm: "
                "8 says, 533 px"));
  EXPECT_THAT(
      message({"camera.preset=gen3_vga", "camera.focal_mm=8", "camera.fx_px=400"}),
      HasSubstr("camera.focal_mm: found 8 (a focal length of 533 px), expected what fx_px: 400 says"));
  EXPECT_EQ(message({"camera.preset=gen3_vga", "camera.focal_mm=8", "camera.fx_px=534"}), "accepted");
  EXPECT_THAT(message({"camera.width_px=300", "camera.focal_mm=8"}),
              HasSubstr("camera.focal_mm: found 8, expected pixel_pitch_um beside it"));
  EXPECT_THAT(message({"camera.preset=gen3_vga", "camera.pixel_pitch_um=9"}),
              HasSubstr("camera.pixel_pitch_um: found 9, expected focal_mm beside it"));
  EXPECT_THAT(message({"camera.preset=davis346", "camera.p1=0.1"}),
              HasSubstr("camera.p1: found an unknown key"));
}

TEST_F(ScenarioDefaults, ACameraThatIsHardlyOneGivesAWarning) {
  EXPECT_THAT(warnings_of(read({"camera.preset=gen3_vga", "camera.focal_mm=200"})),
              testing::Contains(HasSubstr("camera: the camera sees 2.7 deg from left to right")));
  EXPECT_THAT(warnings_of(read({"camera.preset=gen3_vga", "camera.fx_px=800"})),
              testing::Contains(HasSubstr("differ by more than 5 %")));
}

TEST_F(ScenarioDefaults, TheResolvedScenarioHasTheSameCameras) {
  for (const auto& sets :
       {std::vector<std::string>{"camera.width_px=346", "camera.fx_px=300"},
        {"camera.preset=icub_right_2016", "camera.cy_px=60"},
        {"camera.preset=davis346", "camera.width_px=300", "camera.field_of_view_deg=70", "eyes=both"},
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
