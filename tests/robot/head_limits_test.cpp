#include "robot/head_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.h"

namespace saccade {
namespace {

using testing::HasSubstr;

/// The limits of a robot, those of the default configuration but for neck pitch, deg.
JointLimits robot_with_pitch(double min_deg, double max_deg) {
  JointLimits limits = joint_limits({});
  limits.min_rad[neck_pitch] = min_deg * rad_per_deg;
  limits.max_rad[neck_pitch] = max_deg * rad_per_deg;
  return limits;
}

TEST(CommonLimits, ARobotWithWiderLimitsIsFineAndTheConfiguredOnesApply) {
  const JointLimits ours = joint_limits({});
  const CommonLimits common = common_limits(ours, robot_with_pitch(-30.0, 22.0));  // iCubGenova02's board
  EXPECT_TRUE(common.check.passed) << common.check.found;
  EXPECT_EQ(common.check.found, "the configured ones");
  EXPECT_EQ(common.limits.min_rad, ours.min_rad);
  EXPECT_EQ(common.limits.max_rad, ours.max_rad);
}

TEST(CommonLimits, TighterLimitsOfTheRobotNarrowTheConfiguredOnesAndAreNamed) {
  const CommonLimits common = common_limits(joint_limits({}), robot_with_pitch(-20.0, 12.0));
  EXPECT_TRUE(common.check.passed);
  EXPECT_THAT(common.check.found, HasSubstr("narrowed by the robot: neck_pitch -20 to 12"));
  EXPECT_NEAR(common.limits.min_rad[neck_pitch], -20.0 * rad_per_deg, 1e-12);
  EXPECT_NEAR(common.limits.max_rad[neck_pitch], 12.0 * rad_per_deg, 1e-12);
}

TEST(CommonLimits, TighterLimitsOfOnesOwnApply) {
  HeadLimitsConfig own;
  own.range_deg[0] = {-10.0, 5.0};  // neck pitch
  const CommonLimits common = common_limits(joint_limits(own), robot_with_pitch(-30.0, 22.0));
  EXPECT_TRUE(common.check.passed) << common.check.found;
  EXPECT_NEAR(common.limits.max_rad[neck_pitch], 5.0 * rad_per_deg, 1e-12);
}

TEST(CommonLimits, AJointWithoutACommonRangeFailsTheCheck) {
  const JointLimits ours = joint_limits({});
  for (const auto& [min_deg, max_deg] : {std::pair{20.0, 40.0}, {0.0, 0.0}, {0.0, std::nan("")}}) {
    const CommonLimits common = common_limits(ours, robot_with_pitch(min_deg, max_deg));
    EXPECT_FALSE(common.check.passed) << min_deg;
    EXPECT_THAT(common.check.found, HasSubstr("neck_pitch"));
    EXPECT_EQ(common.limits.max_rad, ours.max_rad);
  }
}

}  // namespace
}  // namespace saccade
