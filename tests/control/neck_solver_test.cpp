#include "control/neck_solver.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/control/genova02.h"

namespace saccade {
namespace {

NeckSolver genova02_neck() {
  const JointLimits limits = genova02_limits();
  return {default_head(), limits.min_rad.segment<3>(neck_pitch), limits.max_rad.segment<3>(neck_pitch)};
}

const NeckVector straight = NeckVector::Zero();

NeckVector solve_deg(const Eigen::Vector3d& target_m, const NeckVector& start_rad = straight) {
  const NeckSolver::Pose pose = genova02_neck().solve(JointVector::Zero(), target_m, start_rad);
  EXPECT_TRUE(pose.converged) << target_m.transpose();
  return pose.neck_rad / rad_per_deg;
}

/// Where a target is in the cyclopean eye of a head with that neck, deg: + right, + up.
Eigen::Vector2d seen_deg(const JointVector& torso, const NeckVector& neck_deg,
                         const Eigen::Vector3d& target_m) {
  JointVector q = torso;
  q.segment<3>(neck_pitch) = neck_deg * rad_per_deg;
  const Eigen::Vector3d p = CyclopeanEye(default_head()->chain, q).see(target_m);
  return Eigen::Vector2d(std::atan2(p.x(), p.z()), -std::atan2(p.y(), std::hypot(p.x(), p.z()))) /
         rad_per_deg;
}

void expect_near(const NeckVector& found_deg, const NeckVector& expected_deg) {
  EXPECT_LT((found_deg - expected_deg).cwiseAbs().maxCoeff(), 0.1)
      << "found " << found_deg.transpose() << ", expected " << expected_deg.transpose();
}

TEST(NeckSolver, FindsTheReferencePosesOnBothSides) {
  for (const double side : {1.0, -1.0}) {
    expect_near(solve_deg({-0.5, side * 0.15, 0.25}), {-9.7, side * 5.2, side * -16.3});
    expect_near(solve_deg({-0.5, side * 0.15, 0.45}), {11.4, side * -0.7, side * -16.1});
    expect_near(solve_deg({-0.356, side * 0.15, 0.25}), {-12.2, side * 8.9, side * -22.0});
  }
}

TEST(NeckSolver, AtTheUpperLimitTheHeadRollsAndInTheMiddleDoesNotReachTheTarget) {
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector3d target_m(-0.5, side * 0.15, 0.55);
    const NeckVector neck_deg = solve_deg(target_m);
    EXPECT_NEAR(neck_deg[0], 17.0, 1e-9);  // the pitch's stop
    EXPECT_NEAR(neck_deg[1], side * -15.8, 0.1);
    EXPECT_LT(seen_deg(JointVector::Zero(), neck_deg, target_m).norm(), 0.01);
  }
  for (const auto& [target_m, short_deg] :
       {std::pair{Eigen::Vector3d(-0.5, 0.0, 0.55), 5.1}, {Eigen::Vector3d(-0.356, 0.0, 0.50), 6.4}}) {
    const NeckVector neck_deg = solve_deg(target_m);
    const Eigen::Vector2d left_deg = seen_deg(JointVector::Zero(), neck_deg, target_m);
    EXPECT_NEAR(neck_deg[1], 0.0, 1e-3);
    EXPECT_NEAR(left_deg[1], short_deg, 0.1);
    EXPECT_NEAR(left_deg[0], 0.0, 1e-3);
  }
}

TEST(NeckSolver, AcrossTheMiddleOfTheUpperLimitTheRollChangesSignWithTheHeadLowered) {
  // As a ball moves from right to left along the edge, each pose the start of the next search.
  NeckVector neck_deg = solve_deg({-0.5, 0.15, 0.55});
  const double first_roll_deg = neck_deg[1];
  double furthest_off_deg = 0.0;
  for (double y_m = 0.15; y_m > -0.151; y_m -= 0.01) {
    neck_deg = solve_deg({-0.5, y_m, 0.55}, neck_deg * rad_per_deg);
    furthest_off_deg =
        std::max(furthest_off_deg, seen_deg(JointVector::Zero(), neck_deg, {-0.5, y_m, 0.55}).norm());
  }
  EXPECT_NEAR(neck_deg[1], -first_roll_deg, 0.01);
  EXPECT_GT(furthest_off_deg, 3.0);
  std::printf("roll from %.1f to %.1f deg, the axis up to %.1f deg below the ball\n", first_roll_deg,
              neck_deg[1], furthest_off_deg);
}

TEST(NeckSolver, WithTheHeadDownTheRollStaysAtRest) {
  const NeckSolver neck = genova02_neck();
  const double lowest_rad = genova02_limits().min_rad[neck_pitch];
  EXPECT_NEAR(neck.guard(lowest_rad + 5.5 * rad_per_deg), 0.5, 1e-12);
  EXPECT_LT(neck.guard(lowest_rad + 5.2 * rad_per_deg), 0.01);
  EXPECT_GT(neck.guard(lowest_rad + 5.8 * rad_per_deg), 0.99);
  for (const double side : {1.0, -1.0}) {
    const NeckVector neck_deg = solve_deg({-0.356, side * 0.10, 0.15});
    EXPECT_LT(neck_deg[0], -25.0);
    EXPECT_NEAR(neck_deg[1], 0.0, 0.01);
    EXPECT_LT(neck_deg[2] * side, -15.0);
  }
}

TEST(NeckSolver, IsExactWithinLimitsAndGuardAndNeverViolatesThem) {
  const NeckSolver neck = genova02_neck();
  const JointLimits limits = genova02_limits();
  const RandomStream random(1, "targets");
  int exact = 0, most_iterations = 0, unsettled = 0;
  NeckVector start_rad = straight;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    JointVector q = JointVector::Zero();
    for (int j = 0; j < torso_joint_count; ++j) {
      q[j] = random.uniform(-10, 10, static_cast<std::uint64_t>(j), i) * rad_per_deg;
    }
    const Eigen::Vector3d target_m(random.uniform(-0.7, -0.3, 3, i), random.uniform(-0.3, 0.3, 4, i),
                                   random.uniform(0.1, 0.7, 5, i));
    const NeckSolver::Pose pose = neck.solve(q, target_m, start_rad);
    start_rad = pose.neck_rad;
    ASSERT_TRUE(pose.neck_rad.allFinite());
    most_iterations = std::max(most_iterations, pose.iterations);
    unsettled += !pose.converged;
    ASSERT_TRUE((pose.neck_rad.array() >= limits.min_rad.segment<3>(neck_pitch).array() - 1e-12).all());
    ASSERT_TRUE((pose.neck_rad.array() <= limits.max_rad.segment<3>(neck_pitch).array() + 1e-12).all());
    const NeckVector rest_rad = neck.rest(q);
    const double roll = pose.neck_rad[1] - rest_rad[1], f = neck.guard(pose.neck_rad[0]);
    ASSERT_LE(roll, (limits.max_rad[neck_roll] - rest_rad[1]) * f + 1e-12);
    ASSERT_GE(roll, (limits.min_rad[neck_roll] - rest_rad[1]) * f - 1e-12);
    exact += seen_deg(q, pose.neck_rad / rad_per_deg, target_m).norm() < 0.01;
  }
  EXPECT_GT(exact, 700);
  EXPECT_LT(unsettled, 10);  // along a limit the search may creep; the next one goes on from there
  std::printf("%d of 1000 poses exact, at most %d iterations, %d not settled\n", exact, most_iterations,
              unsettled);
}

TEST(NeckSolver, OfTheExactPosesItGivesTheOneNearestToRest) {
  // Turning on along the line of poses that keep the axis on the target leads away from rest on both sides.
  const Eigen::Vector3d target_m(-0.5, 0.15, 0.25);
  const NeckVector best_deg = solve_deg(target_m);
  for (const double roll_deg : {best_deg[1] - 2.0, best_deg[1] + 2.0}) {
    NeckVector neck_deg = best_deg;
    neck_deg[1] = roll_deg;
    for (int i = 0; i < 100; ++i) {  // pitch and yaw that aim with that roll
      const Eigen::Vector2d off_deg = seen_deg(JointVector::Zero(), neck_deg, target_m);
      neck_deg[0] += 0.5 * off_deg[1];
      neck_deg[2] -= 0.5 * off_deg[0];
    }
    ASSERT_LT(seen_deg(JointVector::Zero(), neck_deg, target_m).norm(), 1e-3);
    EXPECT_GT(neck_deg.norm(), best_deg.norm() + 0.05);
  }
}

TEST(NeckSolver, TheRestPoseLevelsTheHeadForAnyTorsoPose) {
  JointVector q = JointVector::Zero();
  EXPECT_LT(genova02_neck().rest(q).norm(), 1e-12);
  q.head<3>() << 10 * rad_per_deg, -8 * rad_per_deg, 20 * rad_per_deg;
  const NeckVector rest_rad = genova02_neck().rest(q);
  EXPECT_EQ(rest_rad[2], 0.0);
  q.segment<3>(neck_pitch) = rest_rad;
  const Eigen::Vector3d down = CyclopeanEye(default_head()->chain, q).root_from_eye().linear().col(1);
  EXPECT_LT((down + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_GT(rest_rad.norm(), 5.0 * rad_per_deg);
}

}  // namespace
}  // namespace saccade
