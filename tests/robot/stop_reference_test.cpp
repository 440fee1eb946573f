#include "robot/stop_reference.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/robot/scripted_world.h"

namespace saccade {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(StopReference, IsThePositionOfTheNewestReading) {
  StopReference stop;
  HeadState state;
  state.position_rad[neck_yaw] = 0.1;
  stop.update(state);
  state.position_rad[neck_yaw] = 0.2;
  stop.update(state);
  EXPECT_EQ(stop.reference_rad(unit_limits()), state.head_position_rad());
}

TEST(StopReference, KeepsTheLastFinitePositionOfAJointWhoseEncoderReadsNan) {
  StopReference stop;
  HeadState state;
  state.position_rad[neck_yaw] = 0.1;
  state.position_rad[eyes_tilt] = 0.3;
  stop.update(state);
  state.position_rad[neck_yaw] = 0.2;
  HeadJointVector expected_rad = state.head_position_rad();
  state.position_rad[eyes_tilt] = nan;
  stop.update(state);
  EXPECT_EQ(stop.reference_rad(unit_limits()), expected_rad);
}

TEST(StopReference, IsKnownFromPositionsAloneWhenAVelocityIsNotFinite) {
  StopReference stop;
  HeadState state;
  state.position_rad[neck_yaw] = 0.1;
  state.velocity_rad_s[neck_yaw] = nan;
  stop.update(state);
  EXPECT_EQ(stop.reference_rad(unit_limits()), state.head_position_rad());
}

TEST(StopReference, LiesInsideTheLimits) {
  StopReference stop;
  HeadState state;
  const JointLimits limits = unit_limits();
  state.position_rad[neck_yaw] = limits.max_rad[neck_yaw] + 0.1;
  stop.update(state);
  ASSERT_TRUE(stop.reference_rad(limits));
  EXPECT_EQ((*stop.reference_rad(limits))[neck_yaw - torso_joint_count], limits.max_rad[neck_yaw]);
}

TEST(StopReference, IsNoneBeforeAFiniteReading) {
  StopReference stop;
  EXPECT_FALSE(stop.reference_rad(unit_limits()));
  HeadState state;
  state.position_rad[neck_yaw] = nan;
  stop.update(state);
  EXPECT_FALSE(stop.reference_rad(unit_limits()));
}

}  // namespace
}  // namespace saccade
