#include "robot/stop_reference.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "robot/reference_outlet.h"
#include "tests/robot/scripted_world.h"

namespace saccade {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(StopReference, IsTheNewestPosition) {
  const std::array position_deg{1.0, -2.0};
  const std::array reference_deg{5.0, 5.0};
  const auto reference_rad = stop_reference(position_deg, reference_deg, 2, unit_limits());
  ASSERT_TRUE(reference_rad);
  EXPECT_DOUBLE_EQ((*reference_rad)[0], 1.0 * rad_per_deg);
  EXPECT_DOUBLE_EQ((*reference_rad)[1], -2.0 * rad_per_deg);
}

TEST(StopReference, IsTheLastReferenceOfAJointWhoseEncoderReadsNan) {
  const std::array position_deg{1.0, nan};
  const std::array reference_deg{5.0, 4.0};
  const auto reference_rad = stop_reference(position_deg, reference_deg, 2, unit_limits());
  ASSERT_TRUE(reference_rad);
  EXPECT_DOUBLE_EQ((*reference_rad)[0], 1.0 * rad_per_deg);
  EXPECT_DOUBLE_EQ((*reference_rad)[1], 4.0 * rad_per_deg);
}

TEST(StopReference, IsTheLastReferenceOfAJointThatTheMessageLacks) {
  const std::array position_deg{1.0};
  const std::array reference_deg{5.0, 4.0};
  const auto reference_rad = stop_reference(position_deg, reference_deg, 2, unit_limits());
  ASSERT_TRUE(reference_rad);
  EXPECT_DOUBLE_EQ((*reference_rad)[1], 4.0 * rad_per_deg);
}

TEST(StopReference, IsNoneIfAnEncoderReadsNanBeforeTheFirstCommand) {
  const std::array position_deg{1.0, nan};
  EXPECT_FALSE(stop_reference(position_deg, {}, 2, unit_limits()));
  EXPECT_TRUE(stop_reference(position_deg, {}, 1, unit_limits()));
}

TEST(StopReference, LiesInsideTheLimits) {
  const JointLimits limits = unit_limits();
  const double most_rad = limits.max_rad[torso_slots];
  const std::array position_deg{most_rad / rad_per_deg + 1.0};
  const auto reference_rad = stop_reference(position_deg, {}, 1, limits);
  ASSERT_TRUE(reference_rad);
  EXPECT_EQ((*reference_rad)[0], most_rad);
}

TEST(ReferenceOutlet, AHaltIsAHaltWithAndWithoutAReferenceToHoldAt) {
  ReferenceOutlet outlet;
  EXPECT_FALSE(outlet.to_send()) << "nothing was commanded";
  outlet.halt();  // nothing is known of the joints, and nothing was sent
  EXPECT_TRUE(outlet.halted());
  outlet.command({1.0});
  EXPECT_FALSE(outlet.to_send()) << "a tick that hung and resumes commands nothing";
  outlet.resume();
  EXPECT_FALSE(outlet.to_send()) << "nor later";
  outlet.command({1.0});
  EXPECT_EQ(outlet.to_send()->at(0), 1.0);
  outlet.halt();
  outlet.hold_at({2.0});
  outlet.command({3.0});
  EXPECT_EQ(outlet.to_send()->at(0), 2.0);
  outlet.resume();
  outlet.halt();
  EXPECT_FALSE(outlet.to_send()) << "not the reference of the halt before";
}

}  // namespace
}  // namespace saccade
