#include "config/robot_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/deploy/robot_backends.h"
#include "external/external_robot.h"
#include "head/head_model.h"
#include "tests/config/built_in.h"
#include "tests/control/genova02.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const fs::path robots = fs::path(SACCADE_SOURCE_DIR) / "scenarios" / "robots";

/// A whole robot file with the least in it.
const std::string least = R"(name: mine
backend: recording
recording: {path: some/run}
calibration: {width_px: 128, height_px: 128, fx_px: 99, fy_px: 99, cx_px: 64, cy_px: 69, k1: 0, k2: 0, p1: 0, p2: 0}
detectors: {best: {}}
)";

Registry robots_too() {
  Registry registry = built_in();
  registry.backends = built_in_backends();
  add_external_robots(registry.backends);
  return registry;
}

std::string recording_path(const RobotFile& file) {
  RobotBackendConfig robot = file.robot;
  return robot.get<RecordingBackendConfig>().path;
}

std::string complaint(const fs::path& path, const std::vector<std::string>& sets = {}) {
  try {
    static_cast<void>(read_robot_file(path, sets, robots_too()));
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(RobotFile, TheExamplesReadAndReadBackTheSame) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(robots)) {
    SCOPED_TRACE(entry.path());
    const RobotFile robot = read_robot_file(entry.path(), {}, robots_too());
    TempFolder folder;
    const std::string resolved = resolved_robot_file(robot);
    EXPECT_EQ(resolved_robot_file(read_robot_file(folder.write("robot.yaml", resolved), {}, robots_too())),
              resolved);
    EXPECT_NE(robot.gaze.detector, "none");
    ++count;
  }
  EXPECT_GE(count, 1);
}

TEST(RobotFile, PathsAreRelativeToTheFileAndThoseOfSetToTheWorkingFolder) {
  TempFolder folder;
  const fs::path file = folder.write("robot.yaml", least);
  EXPECT_EQ(recording_path(read_robot_file(file, {}, robots_too())), folder / "some/run");
  EXPECT_EQ(recording_path(read_robot_file(file, {"recording.path=other"}, robots_too())),
            fs::current_path() / "other");
}

TEST(RobotFile, WithoutACalibrationThereIsNoRobot) {
  TempFolder folder;
  const std::string without = least.substr(0, least.find("calibration")) + "detectors: {best: {}}\n";
  EXPECT_THAT(complaint(folder.write("robot.yaml", without)),
              HasSubstr("calibration: found no such key, expected a block of keys"));
  EXPECT_THAT(complaint(folder.write("robot.yaml", without + "calibration: {width_px: 128, k1: 0}\n")),
              AllOf(HasSubstr("calibration.fx_px: found no such key"), HasSubstr("calibration.p2")));
  folder.write(
      "left.yaml",
      "calibration: {width_px: 128, height_px: 128, fx_px: 77, fy_px: 99, cx_px: 64, cy_px: 69, k1: 0, k2: "
      "0, p1: 0, p2: 0}\n");
  const fs::path file = folder.write("robot.yaml", without + "calibration: {file: left.yaml}\n");
  EXPECT_EQ(read_robot_file(file, {}, robots_too()).calibration.camera.fx_px, 77.0);
}

TEST(RobotFile, EverythingThatIsWrongIsReportedAtOnce) {
  TempFolder folder;
  const fs::path file =
      folder.write("robot.yaml", least + R"(limits: {neck_yaw_deg: [45, -45], neck_jaw_deg: [0, 1]}
gaze: {detector: worst, controller: script}
deploy: {watchdog: {camera_silent_ms: 95}, ramp_in: 2}
)");
  const std::string text = complaint(file, {"backend=toaster"});
  for (const char* expected :
       {"--set backend: found toaster", "robot.yaml:6: limits.neck_yaw_deg: found [45, -45]",
        "did you mean neck_yaw_deg?", "gaze.detector: found worst",
        "deploy.watchdog.safe_within_ms: found 100, expected at least 132", "deploy.ramp_in"})
    EXPECT_THAT(text, HasSubstr(expected));
}

TEST(RobotFile, OurLimitsAreTheRobotsOf2016UnlessTheFileSaysOtherwise) {
  const JointLimits ours = joint_limits({});
  const JointLimits genova = genova02_limits();
  for (const HeadJoint& joint : ours.head->joints) {
    if (joint.role == JointRole::torso) continue;
    EXPECT_NEAR(ours.min_rad[joint.slot], genova.min_rad[joint.slot], 1e-12) << joint.name;
    EXPECT_NEAR(ours.max_rad[joint.slot], genova.max_rad[joint.slot], 1e-12) << joint.name;
  }
}

TEST(RobotFile, AGuardIsRequiredOnlyOfAHeadThatAnotherProcessCanStop) {
  EXPECT_THAT(
      complaint(robots / "recording.yaml", {"deploy.guard=required"}),
      AllOf(HasSubstr("deploy.guard"), HasSubstr("no other process can stop the head of this backend")));
  EXPECT_EQ(complaint(robots / "icub.yaml", {"deploy.guard=required"}), "nothing");
  EXPECT_EQ(complaint(robots / "practice.yaml", {"deploy.guard=required"}), "nothing");
}

TEST(RobotFile, EveryShippedOneWhoseHeadAnotherProcessCanStopRequiresTheGuard) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(robots)) {
    const RobotFile file = read_robot_file(entry.path(), {}, robots_too());
    if (file.robot.head_name().empty()) continue;
    ++found;
    EXPECT_EQ(file.deploy.guard, GuardUse::required) << entry.path();
  }
  EXPECT_GE(found, 4);
}

}  // namespace
}  // namespace saccade
