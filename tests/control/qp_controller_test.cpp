#include "control/qp_controller.h"

#include <gtest/gtest.h>

#include <iostream>
#include <limits>
#include <memory>
#include <numbers>

#include "control/gate_registry.h"
#include "core/error.h"
#include "head/icub_cameras.h"
#include "tests/control/gaze_plant.h"
#include "tests/control/malloc_count.h"

namespace saccade {
namespace {

TEST(QpController, ReachesEveryReachableTargetWithBothEyes) {
  const RandomStream random(1, "targets");
  const auto gaze = controller();
  Plant plant;  // one head goes from target to target
  double worst_deg = 0.0, worst_right_deg = 0.0, worst_fixation_m = 0.0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Eigen::Vector3d target = random_target(random, i);
    run(*gaze, plant, target, 1.2);
    worst_deg = std::max(worst_deg, angle_deg(Eye::left, plant.state.position_rad, target));
    worst_right_deg = std::max(worst_right_deg, angle_deg(Eye::right, plant.state.position_rad, target));
    const FixationPoint fixation = HeadKinematics(default_head()->chain, plant.state.position_rad).fixation();
    ASSERT_TRUE(fixation.valid);
    worst_fixation_m = std::max(worst_fixation_m, (fixation.point_m - target).norm());
  }
  EXPECT_LT(worst_deg, 0.1);
  EXPECT_LT(worst_right_deg, 0.2);
  EXPECT_LT(worst_fixation_m, 0.005);
  std::printf("after 1.2 s: left eye %.4f deg, right eye %.4f deg, fixation %.5f m off at worst\n", worst_deg,
              worst_right_deg, worst_fixation_m);
}

TEST(QpController, IsWithinAPixelAfterAThirdOfASecond) {
  const RandomStream random(2, "targets");
  std::vector<double> times_s;
  for (std::uint64_t i = 0; i < 101; ++i) {
    const Eigen::Vector3d target = random_target(random, i);
    const auto gaze = controller();
    Plant plant;
    double since_s = 0.0;
    for (int tick = 0; tick < 800; ++tick) {
      plant.follow(gaze->step(plant.state, target, dt));
      if (angle_deg(Eye::left, plant.state.position_rad, target) > 0.576) since_s = tick * dt;
    }
    times_s.push_back(since_s);
  }
  std::sort(times_s.begin(), times_s.end());
  EXPECT_LT(times_s[50], 0.34);
  std::printf("within 0.576 deg after %.3f s in the middle, %.3f s at worst\n", times_s[50], times_s.back());
}

TEST(QpController, NeverViolatesLimitsForTargetsWithinAndOutOfReach) {
  const RandomStream random(3, "targets");
  const auto gaze = controller();
  Plant plant;
  plant.state.position_rad[eyes_vergence] = 1.0 * rad_per_deg;  // out of the margin
  const MotionLimits l = motion_limits(genova02_limits(), {});
  HeadJointVector last = plant.state.head_position_rad(), velocity = HeadJointVector::Zero();
  JointLimiter limiter(l);
  long limited = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    // Anywhere in a cube of 2 m around the head, behind and inside of it too.
    const Eigen::Vector3d target(random.uniform(-1, 1, 0, i), random.uniform(-1, 1, 1, i),
                                 random.uniform(-0.65, 1.35, 2, i));
    for (int tick = 0; tick < 150; ++tick) {
      const HeadJointVector reference = gaze->step(plant.state, target, dt);
      const HeadJointVector next_velocity = (reference - last) / dt;
      ASSERT_FALSE(violates(reference));
      ASSERT_TRUE((reference.array() >= l.min_rad.array() && reference.array() <= l.max_rad.array()).all());
      ASSERT_TRUE((next_velocity.array().abs() <= l.speed_rad_s.array() + 1e-9).all());
      ASSERT_TRUE(
          ((next_velocity - velocity).array().abs() <= l.acceleration_rad_s2.array() * dt * (1 + 1e-6))
              .all());
      last = reference;
      velocity = next_velocity;
      const auto stage = limiter.apply(reference, plant.state.head_position_rad(), dt);
      limited += (stage.position | stage.speed | stage.acceleration).any();
      ASSERT_LT((stage.reference_rad - reference).cwiseAbs().maxCoeff(), 1e-12);
      plant.follow(reference);
      ASSERT_FALSE(violates(plant.state.head_position_rad()));
    }
  }
  EXPECT_EQ(limited, 0);  // the controller keeps the limits by itself
}

TEST(QpController, ApproachesATargetOutOfReachAsFarAsTheLimitsAllow) {
  // Compared with the best that coordinate descent finds from every corner of the box of joint angles.
  const MotionLimits l = motion_limits(genova02_limits(), {});
  for (const Eigen::Vector3d& target :
       {seen_at(0, 70, 0.5), seen_at(-88, 0, 0.6), seen_at(40, -80, 0.5), seen_at(75, 60, 0.5)}) {
    ASSERT_EQ(check_gaze_target(target, HeadKinematics(default_head()->chain, JointVector::Zero())),
              TargetStatus::ok);
    const auto gaze = controller();
    Plant plant;
    run(*gaze, plant, target, 6.0);
    const double reached_deg = angle_deg(Eye::left, plant.state.position_rad, target);

    double best_deg = 180.0;
    for (int corner = 0; corner < 64; ++corner) {
      JointVector q = JointVector::Zero();
      for (int j = 0; j < head_joint_count; ++j) {
        q[torso_joint_count + j] = corner >> j & 1 ? l.max_rad[j] : l.min_rad[j];
      }
      double here = angle_deg(Eye::left, q, target);
      for (double step = 16.0 * rad_per_deg; step > 1e-4 * rad_per_deg; step /= 2) {
        for (bool better = true; better;) {
          better = false;
          for (int j = 0; j < head_joint_count; ++j) {
            for (const double sign : {1.0, -1.0}) {
              JointVector moved = q;
              double& angle = moved[torso_joint_count + j];
              angle = std::clamp(angle + sign * step, l.min_rad[j], l.max_rad[j]);
              const double there = angle_deg(Eye::left, moved, target);
              if (there < here - 1e-9) {
                here = there;
                q = moved;
                better = true;
              }
            }
          }
        }
      }
      best_deg = std::min(best_deg, here);
    }
    std::printf("out of reach: %.2f deg, the best possible %.2f deg\n", reached_deg, best_deg);
    EXPECT_GT(best_deg, 0.5);
    EXPECT_LT(reached_deg, best_deg + 0.5);  // a level head is worth more than the last tenths of a degree
  }
}

TEST(QpController, TheNeckFollowsAndTheEyesReturnToTheMiddle) {
  const auto gaze = controller();
  Plant plant;
  const Eigen::Vector3d target = seen_at(25, 10, 0.45);
  run(*gaze, plant, target, 0.15);
  const JointVector early = plant.state.position_rad;
  run(*gaze, plant, target, 4.0);
  const JointVector late = plant.state.position_rad;
  EXPECT_GT(early[eyes_version], 12.0 * rad_per_deg);  // the eyes are there first
  EXPECT_LT(std::abs(late[eyes_version]), 0.5 * rad_per_deg);
  EXPECT_LT(std::abs(late[eyes_tilt]), 0.5 * rad_per_deg);
  EXPECT_LT(std::abs(late[neck_roll]), 0.5 * rad_per_deg);
  EXPECT_LT(late[neck_yaw], -20.0 * rad_per_deg);  // + turns left
  EXPECT_LT(angle_deg(Eye::left, late, target), 0.01);
}

TEST(QpController, KeepsTheGazeWhileTheNeckFollows) {
  const auto gaze = controller();
  Plant plant;
  const Eigen::Vector3d target = seen_at(-28, 12, 0.45);
  run(*gaze, plant, target, 0.6);
  double worst_deg = 0.0;
  for (int i = 0; i < 2000; ++i) {
    plant.follow(gaze->step(plant.state, target, dt));
    worst_deg = std::max(worst_deg, angle_deg(Eye::left, plant.state.position_rad, target));
  }
  EXPECT_LT(worst_deg, 0.576);  // a pixel
}

TEST(QpController, TheEyesCoverTheRemainingAngleIfTheNeckIsAtItsLimit) {
  const auto gaze = controller();
  Plant plant;
  const Eigen::Vector3d target(-0.5, 0.0, 0.55);  // the neck alone misses it by 5.1 deg
  run(*gaze, plant, target, 4.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target), 0.02);
  EXPECT_NEAR(plant.state.position_rad[neck_pitch], 16.95 * rad_per_deg, 0.01 * rad_per_deg);
  EXPECT_GT(plant.state.position_rad[eyes_tilt], 3.0 * rad_per_deg);
}

TEST(QpController, CompensatesASteadyPositionErrorOfAJoint) {
  const auto gaze = controller();
  Plant plant;
  plant.sag_rad.head<head_joint_count>() << -3, 1, 0.5, -1, 0.5, 0.5;
  plant.sag_rad *= rad_per_deg;
  const Eigen::Vector3d target = seen_at(15, -5, 0.45);
  run(*gaze, plant, target, 3.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target), 0.01);
}

TEST(QpController, AReferenceLeadsABlockedJointByTheMaximumOnly) {
  const auto gaze = controller();
  Plant plant;
  const Eigen::Vector3d target = seen_at(-40, 15, 0.45);
  const HeadState stuck = plant.state;
  HeadJointVector reference = HeadJointVector::Zero();
  for (int i = 0; i < 5000; ++i) reference = gaze->step(stuck, target, dt);
  // What it may overrun while it brakes: (350 deg/s)^2 / (2 * 15000 deg/s^2) = 4.1 deg.
  EXPECT_LT((reference - stuck.head_position_rad()).cwiseAbs().maxCoeff(), 14.2 * rad_per_deg);
  run(*gaze, plant, target, 2.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target), 0.1);
}

TEST(QpController, FollowsTheTargetThroughACommandDelay) {
  const auto gaze = controller();
  Plant plant;
  const Eigen::Vector3d target = seen_at(20, 10, 0.45);
  std::vector<HeadJointVector> line(20, HeadJointVector::Zero());  // 20 ms
  double late_deg = 0.0;
  for (std::size_t i = 0; i < 3000; ++i) {
    const HeadJointVector reference = gaze->step(plant.state, target, dt);
    plant.follow(line[i % line.size()]);
    line[i % line.size()] = reference;
    if (i > 2000) late_deg = std::max(late_deg, angle_deg(Eye::left, plant.state.position_rad, target));
  }
  EXPECT_LT(late_deg, 0.05);
}

TEST(QpController, HoldsTheNeutralPoseBeforeTheFirstTarget) {
  const auto gaze = controller();
  Plant plant;
  run(*gaze, plant, std::nullopt, 1.0);
  EXPECT_LT(plant.state.position_rad.cwiseAbs().maxCoeff(),
            0.06 * rad_per_deg);  // vergence leaves its margin

  Plant turned;
  turned.state.position_rad.segment<head_joint_count>(torso_slots) << 0.1, -0.2, 0.5, 0.2, -0.3, 0.4;
  run(*controller(), turned, std::nullopt, 5.0);
  EXPECT_LT(turned.state.position_rad.cwiseAbs().maxCoeff(), 0.1 * rad_per_deg);
}

TEST(QpController, KeepsLookingAtTheLastTargetWithoutNewOnes) {
  const auto gaze = controller();
  Plant plant;
  const Eigen::Vector3d target = seen_at(20, -10, 0.4);
  run(*gaze, plant, target, 3.0);
  run(*gaze, plant, std::nullopt, 3.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target), 0.01);
}

TEST(QpController, IgnoresImpossibleTargetsAndReportsWhy) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto gaze = controller();
  Plant plant;
  const Eigen::Vector3d target = seen_at(20, -10, 0.4);
  run(*gaze, plant, target, 3.0);
  for (const auto& [bad, status] :
       {std::pair{Eigen::Vector3d(nan, 0, 0.3), TargetStatus::not_finite},
        {Eigen::Vector3d(-0.4, std::numeric_limits<double>::infinity(), 0.3), TargetStatus::not_finite},
        {Eigen::Vector3d(0.4, 0.1, 0.3), TargetStatus::behind},
        {HeadKinematics(default_head()->chain, plant.state.position_rad).root_from_eye(Eye::left) *
             Eigen::Vector3d(0, 0, 0.09),
         TargetStatus::too_near}}) {
    for (int i = 0; i < 200; ++i) {
      plant.follow(gaze->step(plant.state, bad, dt));
      ASSERT_EQ(gaze->target_status(), status);
    }
    EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target), 0.01);
  }
  (void)gaze->step(plant.state, std::nullopt, dt);
  EXPECT_EQ(gaze->target_status(), TargetStatus::none);
  (void)gaze->step(plant.state, target, dt);
  EXPECT_EQ(gaze->target_status(), TargetStatus::ok);
}

TEST(QpController, HoldsItsReferenceWhileAnEncoderReadsNan) {
  const auto gaze = controller();
  Plant plant;
  HeadState broken = plant.state;
  broken.position_rad[neck_yaw] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(gaze->step(broken, seen_at(20, 0, 0.4), dt).allFinite());
  run(*gaze, plant, seen_at(20, 0, 0.4), 0.05);
  broken = plant.state;
  broken.position_rad[eyes_tilt] = std::numeric_limits<double>::infinity();
  const HeadJointVector held = gaze->step(broken, std::nullopt, dt);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(gaze->step(broken, std::nullopt, dt), held);
  run(*gaze, plant, seen_at(20, 0, 0.4), 2.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, seen_at(20, 0, 0.4)), 0.1);
}

TEST(QpController, FollowsATargetOnACircleOfHalfAHertzWithLittleLag) {
  // 7 cm in radius at 45 cm: 28 deg/s. Without knowing the target's motion the eye would trail by
  // eye_time_constant_s, 1.4 deg.
  const auto gaze = controller();
  Plant plant(0.008);
  double worst_deg = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double angle = std::numbers::pi * i * dt;
    const Eigen::Vector3d target(-0.5, 0.07 * std::cos(angle), 0.347 + 0.07 * std::sin(angle));
    plant.follow(gaze->step(plant.state, target, dt));
    if (i > 2000) worst_deg = std::max(worst_deg, angle_deg(Eye::left, plant.state.position_rad, target));
  }
  std::cout << "worst error " << worst_deg << " deg\n";
  EXPECT_LT(worst_deg, 0.3);
}

TEST(QpController, TheLeftEyeAloneLeavesVergenceAtRest) {
  GazeControllerConfig config = built_in_controllers().config();
  config.get<QpConfig>().eyes = AimingEyes::left;
  const auto gaze = controller(config);
  Plant plant;
  const Eigen::Vector3d target = seen_at(15, 8, 0.35);
  run(*gaze, plant, target, 4.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target), 0.01);
  EXPECT_LT(plant.state.position_rad[eyes_vergence], 0.1 * rad_per_deg);
  EXPECT_GT(angle_deg(Eye::right, plant.state.position_rad, target), 5.0);
}

TEST(QpController, StepsAndGatesDoNotAllocate) {
  if (!malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc";
  const auto gaze = controller();
  const auto gate = make_gate(built_in_gates().config());
  JointLimiter limiter(motion_limits(genova02_limits(), {}));
  const RandomStream random(5, "targets");
  const Camera camera = icub_left_2016;
  Plant plant;
  const long before = malloc_count();
  EXPECT_GT(before, 0);
  long targets = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const CameraMotion motion = camera_motion(default_head()->chain, plant.state);
    const Estimate estimate{true, false, {camera.cx_px + random.normal(9, i), camera.cy_px, 12.0}, 1.0};
    auto target = gate->update(plant.state.t_us, estimate, 0.0, camera, motion.root_from_camera);
    targets += target.has_value();
    if (i % 500 == 0) target = random_target(random, i);
    const HeadJointVector reference = gaze->step(plant.state, target, dt);
    plant.follow(limiter.apply(reference, plant.state.head_position_rad(), dt).reference_rad);
  }
  const long after = malloc_count();
  EXPECT_EQ(after, before);
  EXPECT_GT(targets, 100);
}

TEST(QpController, PredictionAndCompensationDoNotAllocate) {
  if (!malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc";
  GazeControllerConfig config = built_in_controllers().config();
  config.get<QpConfig>().catch_up_deg = 1.0;
  const auto gaze = controller(config);
  Stabiliser stabiliser({true, true}, default_head());
  MotionDelayEstimator delay;
  const ImuReading imu;
  Plant plant;
  const long before = malloc_count();
  for (int i = 0; i < 4000; ++i) {
    const double angle = 2.0 * std::numbers::pi * i * dt;
    const Eigen::Vector3d target(-0.5, 0.07 * std::cos(angle), 0.347 + 0.07 * std::sin(angle));
    gaze->set_delays({0.02, delay.neck_s(), delay.eyes_s()});
    gaze->set_body_rates(stabiliser.update(plant.state, &imu, delay.eyes_s(), dt));
    const HeadJointVector reference = gaze->step(plant.state, target, dt);
    delay.update(plant.state.head_position_rad(), reference, dt);
    plant.follow(reference);
  }
  EXPECT_EQ(malloc_count(), before);
}

TEST(QpController, ACatchUpSaccadeClosesALargeErrorSooner) {
  const auto error_after_a_step_deg = [](double catch_up_deg) {
    GazeControllerConfig config = built_in_controllers().config();
    config.get<QpConfig>().catch_up_deg = catch_up_deg;
    const auto gaze = controller(config);
    Plant plant(0.008);
    run(*gaze, plant, seen_at(0, 0, 0.45), 2.0);
    run(*gaze, plant, seen_at(10, 0, 0.45), 0.12);
    return angle_deg(Eye::left, plant.state.position_rad, seen_at(10, 0, 0.45));
  };
  EXPECT_LT(error_after_a_step_deg(2.0), 0.5 * error_after_a_step_deg(0.0));
}

TEST(QpController, ABadConfigurationIsAnInputError) {
  GazeControllerConfig config = built_in_controllers().config();
  config.get<QpConfig>().damping = 1.0;
  config.get<QpConfig>().eye_time_constant_s = std::numeric_limits<double>::quiet_NaN();
  config.limits.margin_deg = -1.0;
  try {
    (void)controller(config);
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 3u);
  }
}

}  // namespace
}  // namespace saccade
