#include "config/head_section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/scenario.h"
#include "config/yaml_writer.h"
#include "core/units.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const fs::path scenarios = fs::path(SACCADE_SOURCE_DIR) / "scenarios";

const std::string least = R"(name: mine
run: {duration_s: 1}
ball: {trajectory: {kind: hold, points_m: [[-0.5, 0, 0.35]]}}
detectors: {best: {}}
)";

std::string complaint(const fs::path& path, const std::vector<std::string>& sets = {}) {
  try {
    (void)read_scenario(path, sets, std::nullopt, built_in());
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(HeadSection, VersionsOfTheIcubAreComparedAsWritten) {
  const fs::path square = scenarios / "gaze_square_45cm.yaml";
  for (const std::string& version : icub_versions()) {
    const Scenario scenario = read_scenario(square, {"head.version=" + version}, std::nullopt, built_in());
    EXPECT_EQ(scenario.sim.world.head.version, version);
    EXPECT_EQ(head_model(scenario.sim.world.head)->name, "icub version " + version);
    const TempFolder folder;
    const Scenario again =
        read_scenario(folder.write("again.yaml", resolved_scenario(scenario)), {}, std::nullopt, built_in());
    EXPECT_EQ(again.sim.world.head.version, version);
  }
  EXPECT_THAT(complaint(square, {"head.version=2.1"}),
              HasSubstr("head.version: found 2.1, expected one of 1, 2, 2.8, 2.10, 3"));
  EXPECT_THAT(complaint(square, {"head.model=nao"}), HasSubstr("head.model: found nao"));
}

TEST(HeadSection, AVersionInAFileIsTextEvenWithoutQuotes) {
  const TempFolder folder;
  const auto path = folder.write("mine.yaml", least + "head: {version: 2.10}\n");
  EXPECT_EQ(read_scenario(path, {}, std::nullopt, built_in()).sim.world.head.version, "2.10");
}

TEST(HeadSection, AFileIsRelativeToTheScenarioAndStandsInTheResolvedOne) {
  const Scenario scenario =
      read_scenario(scenarios / "gaze_square_pan_tilt.yaml", {}, std::nullopt, built_in());
  const auto head = head_model(scenario.sim.world.head);
  EXPECT_EQ(head->name, "pan_tilt");
  EXPECT_EQ(head->gaze_joints(), 2);
  EXPECT_EQ(scenario.sim.world.plant.command_delay_ms, 10);
  EXPECT_EQ(scenario.sim.world.plant.encoders.quantisation_deg, 0.088);
  const TempFolder folder;
  const std::string resolved = resolved_scenario(scenario);
  EXPECT_EQ(resolved_scenario(read_scenario(folder.write("a.yaml", resolved), {}, std::nullopt, built_in())),
            resolved);
}

TEST(HeadSection, LimitsAreNarrowedAndNeverWidened) {
  const TempFolder folder;
  const auto path =
      folder.write("mine.yaml", least + "head: {limits: {neck_pitch: {min_deg: -10, max_deg: 60}}}\n");
  const auto head = head_model(read_scenario(path, {}, std::nullopt, built_in()).sim.world.head);
  EXPECT_NEAR(head->joints[3].min_rad, -10.0 * rad_per_deg, 1e-15);
  EXPECT_NEAR(head->joints[3].max_rad, 17.0 * rad_per_deg, 1e-15);
  EXPECT_THAT(complaint(path, {"head.limits.neck_pitch.min_deg=20"}),
              HasSubstr("head.limits.neck_pitch: found 20 to 60 deg"));
  EXPECT_THAT(complaint(path, {"head.limits.chin.min_deg=20"}),
              AllOf(HasSubstr("head.limits.chin: found chin, expected a joint of the head: torso_pitch")));
}

TEST(HeadSection, ErrorsOfADescriptionAreOneLineEach) {
  const TempFolder folder;
  const auto with = [&](const std::string& description) {
    folder.write("head.yaml", description);
    return complaint(folder.write("mine.yaml", least + "head: {file: head.yaml}\n"));
  };
  EXPECT_THAT(with("joints: {}\n"), HasSubstr("joints: found 0 joints, expected 1 to 12"));
  EXPECT_THAT(with("name: x\n"), HasSubstr("joints"));
  EXPECT_THAT(with("joints: {pan: {role: arm}}\n"),
              HasSubstr("role: found arm, expected one of torso, neck, eye"));
  EXPECT_THAT(with("joints: {pan: {min_deg: 10, max_deg: 5}}\n"),
              HasSubstr("max_deg: found 5, expected more than min_deg"));
  EXPECT_THAT(with("joints: {pan: {}}\nlinks: {pan: {joint: tilt}}\n"),
              HasSubstr("found tilt, expected one of none, pan"));
  EXPECT_THAT(with("joints: {pan: {}}\nlinks: {pan: {kind: axis, joint: pan}}\nleft_eye: {}\n"),
              HasSubstr("left_eye.pose: found missing"));
  const std::string turret = "joints: {pan: {}}\nlinks: {pan: {a_m: 0.05, joint: pan}}\n";
  EXPECT_EQ(with(turret + "left_eye: {}\n"), "nothing");
  EXPECT_THAT(with(turret), HasSubstr("left_eye: found no such key, expected the eye: links of its own"));
  EXPECT_THAT(with("joints: {pan: {}}\nlinks: {pan: {a_m: 45, joint: pan}}\nleft_eye: {}\n"),
              HasSubstr("links.pan.a_m: found 45, expected a finite number in [-2, 2]"));
  EXPECT_THAT(with(turret + "left_eye: {pose: {position_m: [-20, 0, 350]}}\n"),
              HasSubstr("left_eye.pose.position_m[0]: found -20, expected a finite number in [-3, 3]"));
  EXPECT_THAT(with(turret + "left_eye: {}\nright_eye: {}\n"),
              HasSubstr("right_eye: found an eye at the place of the left one"));
  EXPECT_THAT(
      complaint(folder.write("mine.yaml", least + "head: {model: described, joints: {pan: {}}, links: "
                                                  "{pan: {a_m: 0.05, joint: pan}}}\n")),
      HasSubstr("head.left_eye: found no such key"));
  folder.write("left.ini",
               "type left\nnumLinks 2\nlink_0 (A 45) (D 0) (alpha 90) (offset 0) (min -20) (max 20)\n"
               "link_1 (A 0) (D 0) (alpha 0) (offset 0) (min -20) (max 20)\n");
  EXPECT_THAT(complaint(folder.write("mine.yaml", least + "head: {ikin_left: left.ini}\n")),
              HasSubstr("a_m: found 45, expected a finite number in [-2, 2]"));
  EXPECT_THAT(complaint(folder.write("mine.yaml", least + "head: {file: nowhere.yaml}\n")),
              HasSubstr("nowhere.yaml"));
  EXPECT_THAT(complaint(folder.write("mine.yaml", least + "head: {ikin_right: right.ini}\n")),
              HasSubstr("ikin_left beside it"));
  EXPECT_THAT(complaint(folder.write("mine.yaml", least + "head: {ikin_left: absent.ini}\n")),
              HasSubstr("absent.ini"));
  EXPECT_THAT(complaint(folder.write("mine.yaml", least + "plant: {axes: cad}\nhead: {version: 3}\n")),
              HasSubstr("plant.axes: found cad"));
}

}  // namespace
}  // namespace saccade
