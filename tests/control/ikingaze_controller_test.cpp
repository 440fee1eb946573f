#include "control/ikingaze_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "core/error.h"
#include "tests/control/gaze_plant.h"
#include "tests/control/malloc_count.h"

namespace saccade {
namespace {

GazeControllerConfig ikingaze(AimingEyes eyes = AimingEyes::both, bool saccades = true) {
  GazeControllerConfig config = built_in_controllers().config();
  config.controller = "ikingaze";
  config.get<IkinGazeConfig>().eyes = eyes;
  config.get<IkinGazeConfig>().saccades = saccades;
  return config;
}

/// When a joint that goes from `from` to `to` has done a share of the way for good, s from the first reading.
double time_to(const std::vector<double>& joint, double from, double to, double share) {
  std::size_t since = 0;
  for (std::size_t i = 0; i < joint.size(); ++i) {
    if ((joint[i] - from) / (to - from) < share) since = i + 1;
  }
  return static_cast<double>(since) * dt;
}

/// Azimuth (right) and elevation (up) of the cyclopean axis' error, deg.
double neck_error_deg(const JointVector& q, const Eigen::Vector3d& target_m) {
  return CyclopeanEye(default_head()->chain, q).angle_to(target_m) / rad_per_deg;
}

TEST(IkinGazeController, BothEyesFixateEveryTargetWithinReach) {
  const RandomStream random(1, "targets");
  const auto gaze = controller(ikingaze());
  Plant plant;  // one head goes from target to target
  double worst_deg = 0.0, worst_m = 0.0;
  int reached = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    const Eigen::Vector3d target_m = random_target(random, i);
    run(*gaze, plant, target_m, 2.5);
    const FixationPoint fixation = HeadKinematics(default_head()->chain, plant.state.position_rad).fixation();
    ASSERT_TRUE(fixation.valid);
    const double left_deg = angle_deg(Eye::left, plant.state.position_rad, target_m);
    if (neck_error_deg(plant.state.position_rad, target_m) > 10.0)
      continue;  // the neck's limits keep it away
    ++reached;
    worst_deg = std::max({worst_deg, left_deg, angle_deg(Eye::right, plant.state.position_rad, target_m)});
    worst_m = std::max(worst_m, (fixation.point_m - target_m).norm());
  }
  std::printf("%d targets in reach of the eyes: at worst %.4f deg and %.5f m off\n", reached, worst_deg,
              worst_m);
  EXPECT_GT(reached, 50);
  EXPECT_LT(worst_deg, 0.1);
  EXPECT_LT(worst_m, 0.002);
}

TEST(IkinGazeController, TheLeftEyeAloneLeavesVergenceAtRest) {
  const auto gaze = controller(ikingaze(AimingEyes::left));
  Plant plant;
  for (const Eigen::Vector3d& target_m :
       {seen_at(15, 8, 0.35), seen_at(-20, -5, 0.5), seen_at(-14, -5, 0.5)}) {
    run(*gaze, plant, target_m, 3.0);
    EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target_m), 0.01);
    EXPECT_LT(plant.state.position_rad[eyes_vergence], 0.1 * rad_per_deg);
    EXPECT_GT(angle_deg(Eye::right, plant.state.position_rad, target_m), 3.0);
  }
}

TEST(IkinGazeController, TheNeckMovesWithItsTransferFunctionToTheReferencePoses) {
  const std::vector<std::pair<Eigen::Vector3d, NeckVector>> poses = {
      {{-0.5, 0.15, 0.25}, {-9.7, 5.2, -16.3}},
      {{-0.5, 0.15, 0.45}, {11.4, -0.7, -16.1}},
      {{-0.356, 0.15, 0.25}, {-12.2, 8.9, -22.0}}};
  for (const double side : {1.0, -1.0}) {
    for (const auto& [right_m, right_deg] : poses) {
      const Eigen::Vector3d target_m = right_m.cwiseProduct(Eigen::Vector3d(1, side, 1));
      const NeckVector expected_deg = right_deg.cwiseProduct(NeckVector(1, side, side));
      const auto gaze = controller(ikingaze());
      Plant plant(0.0);
      std::vector<double> yaw;
      for (int tick = 0; tick < 4000; ++tick) {
        yaw.push_back(plant.state.position_rad[neck_yaw]);
        plant.follow(gaze->step(plant.state, tick == 0 ? std::optional(target_m) : std::nullopt, dt));
      }
      const NeckVector neck_deg = plant.state.position_rad.segment<3>(neck_pitch) / rad_per_deg;
      EXPECT_LT((neck_deg - expected_deg).cwiseAbs().maxCoeff(), 0.1) << neck_deg.transpose();
      const double end = plant.state.position_rad[neck_yaw];
      EXPECT_NEAR(time_to(yaw, 0, end, 0.50), 0.50 * 0.75, 0.02 * 0.375);
      EXPECT_NEAR(time_to(yaw, 0, end, 0.90), 1.00 * 0.75, 0.02 * 0.75);
      EXPECT_NEAR(time_to(yaw, 0, end, 0.99), 1.58 * 0.75, 0.02 * 1.185);
      const double furthest = *std::max_element(yaw.begin(), yaw.end(),
                                                [](double a, double b) { return std::abs(a) < std::abs(b); });
      EXPECT_LT(furthest / end - 1.0, 0.002);
    }
  }
}

TEST(IkinGazeController, TheEyesFollowASmallStepWithTheDynamicsOfLoopAndFilter) {
  // Within the neck's activation angle it stays; the eyes' reference closes in with 12.5 / s, a velocity that holds
  // for 20 ms, then comes the filter with three poles at -5.322 / T.
  const auto gaze = controller(ikingaze());
  Plant plant(0.0);
  const Eigen::Vector3d from_m(-0.5, 0.0, 0.347), to_m(-0.5, 0.017, 0.347);
  run(*gaze, plant, from_m, 3.0);
  const double start = plant.state.position_rad[eyes_version];
  const HeadJointVector neck = plant.state.head_position_rad();
  std::vector<double> version;
  for (int tick = 0; tick < 1500; ++tick) {
    version.push_back(plant.state.position_rad[eyes_version]);
    plant.follow(gaze->step(plant.state, tick == 0 ? std::optional(to_m) : std::nullopt, dt));
  }
  EXPECT_LT((plant.state.head_position_rad() - neck).head<3>().cwiseAbs().maxCoeff(), 1e-6);
  // The same, integrated finely.
  const double end = plant.state.position_rad[eyes_version];
  EXPECT_GT((end - start) / rad_per_deg, 1.5);
  double reference = 0.0, reference_velocity = 0.0, velocity = 0.0, acceleration = 0.0, position = 0.0,
         worst = 0.0;
  const double k = 5.3223 / 0.25;
  for (std::size_t tick = 0; tick < version.size(); ++tick) {
    worst = std::max(worst, std::abs((version[tick] - start) / (end - start) - position));
    if (tick % 20 == 0) reference_velocity = 12.5 * (1.0 - reference);
    for (int i = 0; i < 100; ++i) {
      const double h = dt / 100;
      position += h * velocity;
      velocity += h * acceleration;
      acceleration += h * (k * k * k * (reference - position) - 3 * k * k * velocity - 3 * k * acceleration);
      reference += h * reference_velocity;
    }
  }
  std::printf("eyes: at most %.2f %% of the step off their transfer function\n", 100 * worst);
  EXPECT_LT(worst, 0.02);
}

TEST(IkinGazeController, ARampIsFollowedWithTheLagOfFilterAndLoop) {
  const auto gaze = controller(ikingaze(AimingEyes::both, false));
  Plant plant(0.0);
  // A target that circles the eyes in the plane of their axes at 5 deg/s: 0.141 s for the filter, 0.080 s for the
  // reference. The neck moves too; the eyes undo that.
  const double speed_deg_s = 5.0;
  double lag_s = 0.0;
  for (int tick = 0; tick < 4000; ++tick) {
    const double azimuth_deg = -10.0 + speed_deg_s * tick * dt;
    plant.follow(gaze->step(plant.state, seen_at(azimuth_deg, 0, 0.5), dt));
    const FixationPoint fixation = HeadKinematics(default_head()->chain, plant.state.position_rad).fixation();
    if (tick > 2000) {
      ASSERT_TRUE(fixation.valid);
      const double seen_deg = std::atan2(fixation.point_m.y(), -0.0564 - fixation.point_m.x()) / rad_per_deg;
      lag_s = std::max(lag_s, (azimuth_deg + speed_deg_s * dt - seen_deg) / speed_deg_s);
    }
  }
  std::printf("a ramp of %.0f deg/s is followed up to %.4f s late\n", speed_deg_s, lag_s);
  EXPECT_NEAR(lag_s, 0.141 + 0.080, 0.005);
}

TEST(IkinGazeController, ASaccadeMovesToATargetMoreThanTenDegreesAway) {
  const auto reached_deg = [](const GazeControllerConfig& config, double azimuth_deg, double after_s) {
    const auto gaze = controller(config);
    Plant plant;
    run(*gaze, plant, seen_at(0, 0, 0.45), 3.0);
    run(*gaze, plant, seen_at(azimuth_deg, 0, 0.45), after_s);
    return angle_deg(Eye::left, plant.state.position_rad, seen_at(azimuth_deg, 0, 0.45));
  };
  EXPECT_LT(reached_deg(ikingaze(), 20, 0.20), 2.5);  // turned by the neck since the saccade began
  EXPECT_GT(reached_deg(ikingaze(AimingEyes::both, false), 20, 0.20), 8.0);
  EXPECT_GT(reached_deg(ikingaze(), 9, 0.10), 5.0);  // smooth pursuit
  EXPECT_LT(reached_deg(ikingaze(), 12, 0.15), 2.0);
  EXPECT_LT(reached_deg(ikingaze(AimingEyes::left), 12, 0.15), 2.0);
  EXPECT_LT(reached_deg(ikingaze(), 20, 3.0), 0.05);
  EXPECT_LT(reached_deg(ikingaze(AimingEyes::both, false), 20, 3.0), 0.05);
}

TEST(IkinGazeController, SaccadesKeepTheirInterval) {
  // The target jumps by 24 deg every 50 ms. The eyes' speed tells saccades from pursuit.
  for (const double interval_s : {0.2, 0.6}) {
    GazeControllerConfig config = ikingaze();
    config.get<IkinGazeConfig>().saccade_interval_s = interval_s;
    const auto gaze = controller(config);
    Plant plant(0.0);
    run(*gaze, plant, seen_at(-12, 0, 0.45), 3.0);
    std::vector<double> starts_s;
    bool fast = false;
    for (int tick = 0; tick < 5000; ++tick) {
      std::optional<Eigen::Vector3d> target_m;
      if (tick % 50 == 0) target_m = seen_at(tick / 50 % 2 == 0 ? 12 : -12, 0, 0.45);
      plant.follow(gaze->step(plant.state, target_m, dt));
      const double speed_deg_s = std::abs(plant.state.velocity_rad_s[eyes_version]) / rad_per_deg;
      if (!fast && speed_deg_s > 200) starts_s.push_back(tick * dt);
      fast = fast ? speed_deg_s > 100 : speed_deg_s > 200;
    }
    ASSERT_GT(starts_s.size(), 3u);
    double shortest_s = 1e9;
    for (std::size_t i = 1; i < starts_s.size(); ++i)
      shortest_s = std::min(shortest_s, starts_s[i] - starts_s[i - 1]);
    std::printf("interval %.1f s: %zu saccades in 5 s, the shortest interval %.3f s\n", interval_s,
                starts_s.size(), shortest_s);
    EXPECT_GE(shortest_s, interval_s - 0.03);  // of another length, they reach 200 deg/s sooner or later
  }
}

TEST(IkinGazeController, TheNeckFollowsSmallChangesLateAndTheSmallestNotAtAll) {
  const auto neck_starts_s = [](double azimuth_deg) {
    const auto gaze = controller(ikingaze());
    Plant plant(0.0);
    run(*gaze, plant, seen_at(0, 0, 0.45), 3.0);
    for (int tick = 0; tick < 1000; ++tick) {
      plant.follow(gaze->step(plant.state,
                              tick == 0 ? std::optional(seen_at(azimuth_deg, 0, 0.45)) : std::nullopt, dt));
      if (std::abs(plant.state.position_rad[neck_yaw]) > 0.001 * rad_per_deg) return tick * dt;
    }
    return 1.0;
  };
  // Before the neck has turned, the cyclopean eye sees 0.45 m straight ahead as seen_at does.
  EXPECT_LT(neck_starts_s(6.0), 0.03);
  EXPECT_NEAR(neck_starts_s(4.0), 0.25, 0.03);
  EXPECT_EQ(neck_starts_s(2.0), 1.0);
}

TEST(IkinGazeController, KeepsTheGazeWhileTheNeckTurns) {
  for (const AimingEyes eyes : {AimingEyes::both, AimingEyes::left}) {
    const auto gaze = controller(ikingaze(eyes));
    Plant plant(0.0);
    const Eigen::Vector3d target_m = seen_at(-22, 10, 0.45);
    run(*gaze, plant, target_m, 0.35);
    double worst_deg = 0.0, turned_deg = 0.0;
    const double yaw = plant.state.position_rad[neck_yaw];
    for (int tick = 0; tick < 2000; ++tick) {
      plant.follow(gaze->step(plant.state, std::nullopt, dt));
      worst_deg = std::max(worst_deg, angle_deg(Eye::left, plant.state.position_rad, target_m));
      turned_deg = (plant.state.position_rad[neck_yaw] - yaw) / rad_per_deg;
    }
    std::printf("%s: the neck turns on by %.1f deg, the eye is off by %.2f deg at most\n",
                std::string(word_of(eyes)).c_str(), turned_deg, worst_deg);
    EXPECT_GT(turned_deg, 8.0);
    EXPECT_LT(worst_deg, 1.2);
  }
}

TEST(IkinGazeController, StepsOfAnyLengthGiveTheSameMotion) {
  const Eigen::Vector3d target_m = seen_at(18, 9, 0.45);
  const auto after = [&](double step_s) {
    const auto gaze = controller(ikingaze());
    HeadState state;
    for (int i = 0; i < static_cast<int>(std::lround(1.2 / step_s)); ++i) {
      state.position_rad.tail<gaze_slots>() =
          gaze->step(state, i == 0 ? std::optional(target_m) : std::nullopt, step_s);
    }
    return state.head_position_rad();
  };
  const HeadJointVector fine = after(1e-3);
  EXPECT_GT(fine.cwiseAbs().maxCoeff(), 10 * rad_per_deg);
  for (const double step_s : {0.5e-3, 4e-3, 10e-3, 15e-3, 40e-3}) {
    const double off_deg = (after(step_s) - fine).cwiseAbs().maxCoeff() / rad_per_deg;
    std::printf("steps of %.1f ms: %.4f deg from steps of 1 ms\n", 1e3 * step_s, off_deg);
    EXPECT_LT(off_deg, 0.3);
  }
}

TEST(IkinGazeController, TiltStaysWithinItsOwnLimits) {
  GazeControllerConfig config = ikingaze();
  for (const auto& [min_deg, max_deg] : {std::pair{-12.0, 15.0}, {-20.0, 4.0}}) {
    config.get<IkinGazeConfig>().min_tilt_deg = min_deg;
    config.get<IkinGazeConfig>().max_tilt_deg = max_deg;
    const auto gaze = controller(config);
    Plant plant(0.0);
    double lowest_deg = 0.0, highest_deg = 0.0;
    for (const double elevation_deg : {-50.0, 40.0}) {
      run(*gaze, plant, seen_at(0, elevation_deg, 0.45), 0.02);
      for (int tick = 0; tick < 2000; ++tick) {
        plant.follow(gaze->step(plant.state, std::nullopt, dt));
        lowest_deg = std::min(lowest_deg, plant.state.position_rad[eyes_tilt] / rad_per_deg);
        highest_deg = std::max(highest_deg, plant.state.position_rad[eyes_tilt] / rad_per_deg);
      }
    }
    EXPECT_NEAR(lowest_deg, min_deg, 1e-6);
    EXPECT_NEAR(highest_deg, max_deg, 1e-6);
  }
}

TEST(IkinGazeController, CompensatesASteadyPositionErrorOfAJoint) {
  const auto gaze = controller(ikingaze());
  Plant plant;
  plant.sag_rad.head<head_joint_count>() << -3, 1, 0.5, -1, 0.5, 0.5;
  plant.sag_rad *= rad_per_deg;
  const Eigen::Vector3d target_m = seen_at(15, -5, 0.45);
  run(*gaze, plant, target_m, 4.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, target_m), 0.02);
}

TEST(IkinGazeController, AReferenceLeadsABlockedJointByTheMaximumOnly) {
  const auto gaze = controller(ikingaze(AimingEyes::both, false));
  const HeadState stuck;
  HeadJointVector reference = HeadJointVector::Zero();
  for (int i = 0; i < 5000; ++i) reference = gaze->step(stuck, seen_at(-40, 15, 0.45), dt);
  // What it may overrun while it brakes: (350 deg/s)^2 / (2 * 15000 deg/s^2) = 4.1 deg.
  EXPECT_LT(reference.cwiseAbs().maxCoeff(), 14.2 * rad_per_deg);
}

TEST(IkinGazeController, HoldsTheNeutralPoseBeforeTheFirstTargetAndReturnsToItOnRest) {
  Plant turned;
  turned.state.position_rad.segment<head_joint_count>(torso_slots) << 0.1, -0.2, 0.5, 0.2, -0.3, 0.4;
  run(*controller(ikingaze()), turned, std::nullopt, 4.0);
  EXPECT_LT(turned.state.position_rad.cwiseAbs().maxCoeff(), 0.1 * rad_per_deg);

  const auto gaze = controller(ikingaze());
  Plant plant;
  run(*gaze, plant, seen_at(20, -10, 0.4), 3.0);
  run(*gaze, plant, std::nullopt, 1.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, seen_at(20, -10, 0.4)), 0.02);
  gaze->rest();
  run(*gaze, plant, std::nullopt, 4.0);
  EXPECT_LT(plant.state.position_rad.cwiseAbs().maxCoeff(), 0.1 * rad_per_deg);
}

TEST(IkinGazeController, HoldsItsReferenceWhileAnEncoderReadsNan) {
  const auto gaze = controller(ikingaze());
  Plant plant;
  HeadState broken;
  broken.position_rad[neck_yaw] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(gaze->step(broken, seen_at(20, 0, 0.4), dt).allFinite());
  run(*gaze, plant, seen_at(20, 0, 0.4), 0.05);
  broken = plant.state;
  broken.position_rad[eyes_tilt] = std::numeric_limits<double>::infinity();
  const HeadJointVector held = gaze->step(broken, std::nullopt, dt);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(gaze->step(broken, std::nullopt, dt), held);
  run(*gaze, plant, std::nullopt, 3.0);
  EXPECT_LT(angle_deg(Eye::left, plant.state.position_rad, seen_at(20, 0, 0.4)), 0.1);
}

TEST(IkinGazeController, StepsDoNotAllocate) {
  if (!malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc";
  const RandomStream random(5, "targets");
  for (const AimingEyes eyes : {AimingEyes::both, AimingEyes::left}) {
    const auto gaze = controller(ikingaze(eyes));
    Plant plant;
    const long before = malloc_count();
    for (std::uint64_t i = 0; i < 2000; ++i) {
      std::optional<Eigen::Vector3d> target_m;
      if (i % 50 == 0) target_m = random_target(random, i);
      plant.follow(gaze->step(plant.state, target_m, dt));
    }
    EXPECT_EQ(malloc_count(), before);
  }
}

TEST(IkinGazeController, ABadConfigurationIsAnInputError) {
  GazeControllerConfig config = ikingaze();
  config.get<IkinGazeConfig>().min_tilt_deg = 1.0;
  config.get<IkinGazeConfig>().neck_time_s = 0.4;  // too close to the eyes' 0.25
  config.get<IkinGazeConfig>().saccade_angle_deg = std::numeric_limits<double>::quiet_NaN();
  try {
    (void)controller(config);
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 3u);
  }
}

}  // namespace
}  // namespace saccade
