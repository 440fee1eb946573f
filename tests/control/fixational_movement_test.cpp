#include "control/fixational_movement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace saccade {
namespace {

TEST(FixationalMovement, BeginsAfterTheTimeWithoutADetectionAndReturnsToTheTargetAfterOnePeriod) {
  FixationalMovement movement({1.0, 0.3, 2.0});
  int first = 0;
  int count = 0;
  double widest_deg = 0.0;
  Eigen::Vector2d last_deg = Eigen::Vector2d::Zero();
  for (int ms = 1; ms <= 1000; ++ms) {
    const auto at = movement.update(false, true, 1e-3);
    if (!at) continue;
    if (count++ == 0) first = ms;
    EXPECT_LT((*at / rad_per_deg - last_deg).norm(), 0.02) << ms;  // 12.6 deg/s, no jumps
    last_deg = *at / rad_per_deg;
    widest_deg = std::max(widest_deg, std::abs(last_deg.x()));
  }
  EXPECT_EQ(first, 300);
  EXPECT_NEAR(count, 500, 1);
  EXPECT_NEAR(widest_deg, 1.0, 1e-3);
  EXPECT_NEAR(last_deg.norm(), 0.0, 0.02);
}

TEST(FixationalMovement, StaysWhileTheBallIsSeenWithoutATargetAndByDefault) {
  FixationalMovement seen({1.0, 0.1, 2.0});
  FixationalMovement lost({1.0, 0.1, 2.0});
  FixationalMovement off({});
  for (int ms = 0; ms < 1000; ++ms) {
    EXPECT_FALSE(seen.update(ms % 50 == 0, true, 1e-3));
    EXPECT_FALSE(lost.update(false, false, 1e-3));
    EXPECT_FALSE(off.update(false, true, 1e-3));
  }
}

TEST(FixationalMovement, ADisplacedPointIsAsFarAwayAndBesideTheTargetByTheAngle) {
  const HeadKinematics head(default_head()->chain, JointVector::Zero());
  const Eigen::Isometry3d& eye = head.root_from_eye(Eye::left);
  const Eigen::Vector3d target = eye * Eigen::Vector3d(0.0, 0.0, 0.5);
  const Eigen::Vector3d right = eye.inverse() * displaced(target, {2.0 * rad_per_deg, 0.0}, head);
  EXPECT_NEAR(std::atan2(right.x(), right.z()), 2.0 * rad_per_deg, 1e-9);
  EXPECT_NEAR(right.y(), 0.0, 1e-12);
  const Eigen::Vector3d up = eye.inverse() * displaced(target, {0.0, 1.0 * rad_per_deg}, head);
  EXPECT_NEAR(std::atan2(-up.y(), up.z()), 1.0 * rad_per_deg, 1e-9);
}

}  // namespace
}  // namespace saccade
