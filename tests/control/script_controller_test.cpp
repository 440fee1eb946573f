#include "control/script_controller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

constexpr double dt_s = 1e-3;

ScriptConfig two_points() {
  ScriptConfig config;
  config.eyes_deg = {{10, 0}, {10, -12}};
  config.speed_deg_s = 40;
  config.dwell_s = 0.1;
  return config;
}

/// References of tilt and version, deg, for so many ms; the head follows at once.
std::vector<Eigen::Vector2d> play(ScriptController& controller, HeadState& state, int ms) {
  std::vector<Eigen::Vector2d> eyes_deg;
  for (int i = 0; i < ms; ++i) {
    const HeadJointVector reference = controller.step(state, std::nullopt, dt_s);
    state.position_rad.tail<gaze_slots>() = reference;
    eyes_deg.emplace_back(state.position_rad[eyes_tilt] / rad_per_deg,
                          state.position_rad[eyes_version] / rad_per_deg);
  }
  return eyes_deg;
}

TEST(ScriptController, RestsAndMovesThroughThePointsInACycle) {
  ScriptController controller(two_points(), motion_limits(genova02_limits(), {}));
  HeadState state;
  const auto eyes = play(controller, state, 2000);
  // Rest 0.1 s, 10 deg in 0.25 s, rest, 12 deg in 0.3 s, rest, 12 deg back.
  EXPECT_TRUE(eyes[95].isZero(1e-9));
  EXPECT_NEAR(eyes[100 + 125].x(), 5.0, 0.2);  // half way at half time
  EXPECT_TRUE(eyes[360].isApprox(Eigen::Vector2d(10, 0), 1e-6));
  EXPECT_TRUE(eyes[440].isApprox(Eigen::Vector2d(10, 0), 1e-6));
  EXPECT_TRUE(eyes[760].isApprox(Eigen::Vector2d(10, -12), 1e-6));
  EXPECT_TRUE(eyes[1160].isApprox(Eigen::Vector2d(10, 0), 1e-6));
  EXPECT_TRUE(eyes[1560].isApprox(Eigen::Vector2d(10, -12), 1e-6));
}

TEST(ScriptController, MovesWithThePeakSpeedOfMinimumJerk) {
  ScriptController controller(two_points(), motion_limits(genova02_limits(), {}));
  HeadState state;
  const auto eyes = play(controller, state, 1000);
  double fastest_deg_s = 0.0;
  for (std::size_t i = 1; i < eyes.size(); ++i) {
    fastest_deg_s = std::max(fastest_deg_s, (eyes[i] - eyes[i - 1]).norm() / dt_s);
  }
  EXPECT_NEAR(fastest_deg_s, 1.875 * 40, 0.5);
}

TEST(ScriptController, KeepsNeckAndVergenceAtTheirPositions) {
  ScriptController controller(two_points(), motion_limits(genova02_limits(), {}));
  HeadState state;
  state.position_rad[neck_pitch] = -7 * rad_per_deg;
  state.position_rad[neck_yaw] = 4 * rad_per_deg;
  state.position_rad[eyes_vergence] = 6 * rad_per_deg;
  const JointVector before = state.position_rad;
  play(controller, state, 900);
  for (const Joint joint : {neck_pitch, neck_roll, neck_yaw, eyes_vergence}) {
    EXPECT_DOUBLE_EQ(state.position_rad[joint], before[joint]);
  }
}

TEST(ScriptController, StaysWithinTheLimits) {
  ScriptConfig config = two_points();
  config.eyes_deg = {{45, 45}, {-45, -45}};
  const JointLimits limits = genova02_limits();
  ScriptController controller(config, motion_limits(limits, {}));
  HeadState state;
  for (int i = 0; i < 100; ++i) {
    play(controller, state, 50);
    for (const Joint joint : {eyes_tilt, eyes_version}) {
      EXPECT_GE(state.position_rad[joint], limits.min_rad[joint]);
      EXPECT_LE(state.position_rad[joint], limits.max_rad[joint]);
    }
  }
}

TEST(ScriptController, WaitsForReadableEncoders) {
  ScriptController controller(two_points(), motion_limits(genova02_limits(), {}));
  HeadState broken;
  broken.position_rad[neck_roll] = std::nan("");
  EXPECT_TRUE(controller.step(broken, std::nullopt, dt_s).allFinite());
  HeadState state;
  state.position_rad[neck_roll] = 3 * rad_per_deg;
  EXPECT_DOUBLE_EQ(controller.step(state, std::nullopt, dt_s)[neck_roll - neck_pitch], 3 * rad_per_deg);
}

TEST(ScriptController, RejectsAnEmptyScript) {
  ScriptConfig config;
  config.eyes_deg.clear();
  try {
    ScriptController controller(config, motion_limits(genova02_limits(), {}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("script.eyes_deg"));
  }
}

}  // namespace
}  // namespace saccade
