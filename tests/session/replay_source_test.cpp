// Run folders as recordings: the head that moved while they were made.
#include "session/replay_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

TEST(RecordedHead, IsTheHeadOfTheScenarioInTheRunFolder) {
  const TempFolder folder;
  std::string header = "t_us", row = "1000";
  for (const HeadJoint& joint : default_head()->joints) {
    header += "," + joint.name + "_rad";
    row += ",0.1";
  }
  folder.write("joints.csv", header + "\n" + row + "\n");
  EXPECT_EQ(recorded_head(folder / "")->limits.head->name, default_head()->name);
  folder.write("scenario.yaml", "name: a\nhead:\n  version: 2.8\ndetectors: {best: {}}\n");
  EXPECT_EQ(recorded_head(folder / "")->limits.head->name, icub_head("2.8")->name);
}

TEST(RecordedHead, HasItsTorsoInTheSlotsOfTheTorso) {
  const TempFolder folder;
  folder.write("turret.yaml", R"(name: turret
joints:
  waist: {role: torso, min_deg: -90, max_deg: 90}
  pan: {role: eye, min_deg: -90, max_deg: 90}
  tilt: {role: eye, min_deg: -60, max_deg: 60}
links:
  waist: {kind: axis, axis: [0, 0, 1], point_m: [0, 0, 0], joint: waist}
  pan: {kind: axis, axis: [0, 0, -1], point_m: [0, 0, 0.290], joint: pan}
  tilt: {kind: axis, axis: [0, 1, 0], point_m: [0, 0, 0.335], joint: tilt}
left_eye:
  pose: {position_m: [-0.020, 0, 0.350], forward: [-1, 0, 0], up: [0, 0, 1]}
)");
  folder.write("scenario.yaml", "head: {file: turret.yaml}\n");
  folder.write("joints.csv", "t_us,waist_rad,pan_rad,tilt_rad\n1000,0.1,0.2,0.3\n");
  std::optional<RecordedHead> head = recorded_head(folder / "");
  const std::optional<JointsRow> row = head->joints.next();
  EXPECT_EQ(row->position_rad[0], 0.1);
  EXPECT_EQ(row->position_rad[torso_slots], 0.2);
  EXPECT_EQ(row->position_rad[torso_slots + 1], 0.3);
}

TEST(RecordedHead, RejectsATableOfAnotherHeadsJoints) {
  const TempFolder folder;
  folder.write("scenario.yaml", "head: {version: 2}\n");
  folder.write("joints.csv", "t_us,pan_rad,tilt_rad\n1000,0.2,0.3\n");
  EXPECT_THAT([&] { (void)recorded_head(folder / ""); },
              testing::ThrowsMessage<InputError>(HasSubstr("torso_pitch_rad")));
}

TEST(RecordedHead, IsAbsentWithoutATableOfJoints) {
  EXPECT_FALSE(recorded_head(TempFolder() / "").has_value());
}

}  // namespace
}  // namespace saccade
