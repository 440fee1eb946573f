#include "sim/plant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include "core/units.h"
#include "sim/world.h"

namespace saccade {
namespace {

constexpr double deg = rad_per_deg;
constexpr int yaw = neck_yaw - torso_joint_count;

WorldConfig still_world() {
  WorldConfig config;
  config.ball.trajectory.sway_m = 0.0;
  return config;
}

struct Instant {
  HeadState read;                            // readings of the encoders
  JointVector joints = JointVector::Zero();  // true positions
};

/// A head with references 0 and vergence 10 deg at first, and then those of `reference_of`.
template <class Reference>
std::vector<Instant> move(const PlantConfig& plant, int ticks, const Reference& reference_of) {
  WorldConfig config = still_world();
  config.plant = plant;
  config.initial_pose_deg[eyes_vergence] = 10.0;
  World world(config, "", 1);
  std::vector<Instant> instants;
  for (int tick = 0; tick < ticks; ++tick) {
    HeadJointVector reference = HeadJointVector::Zero();
    reference[eyes_vergence - torso_joint_count] = 10.0 * deg;
    reference_of(tick, reference);
    EXPECT_TRUE(world.set_reference(reference));
    world.step();
    instants.push_back({world.head_state(), world.joints_rad()});
  }
  return instants;
}

TEST(Plant, EqualsItsModelByDefault) {
  const auto instants = move({}, 300, [](int tick, HeadJointVector& reference) {
    if (tick >= 10) reference.head<head_joint_count>() << 0.1, -0.1, 0.3, 0.2, -0.2, 0.3;
  });
  for (const Instant& now : instants) ASSERT_EQ(now.read.position_rad, now.joints);
}

TEST(Plant, AppliesACommandAfterTheCommandDelay) {
  const auto step = [](int tick, HeadJointVector& reference) {
    if (tick >= 20) reference[yaw] = 5.0 * deg;
  };
  PlantConfig late;
  late.command_delay_ms = 20;
  const auto prompt = move({}, 200, step);
  const auto delayed = move(late, 200, step);
  for (std::size_t t = 20; t < 180; ++t) {
    ASSERT_NEAR(delayed[t + 20].joints[neck_yaw], prompt[t].joints[neck_yaw], 1e-6 * deg) << t;
  }
  EXPECT_GT(prompt.back().joints[neck_yaw], 4.9 * deg);
}

TEST(Plant, ReadsMultiplesOfTheQuantisation) {
  PlantConfig config;
  config.encoders.quantisation_deg = 0.088;
  const auto instants = move(config, 400, [](int tick, HeadJointVector& reference) {
    reference[yaw] = std::min(0.03 * tick, 10.0) * deg;
    reference[eyes_version - torso_joint_count] = -0.02 * tick * deg;
  });
  for (const Instant& now : instants) {
    // The encoders are at the pans: left and right are version plus and minus half the vergence.
    JointVector motors = now.read.position_rad;
    motors[eyes_version] += 0.5 * now.read.position_rad[eyes_vergence];
    motors[eyes_vergence] = now.read.position_rad[eyes_version] - 0.5 * now.read.position_rad[eyes_vergence];
    for (const double q : motors) {
      ASSERT_NEAR(q / (0.088 * deg), std::round(q / (0.088 * deg)), 1e-6);
    }
    ASSERT_LE(std::abs(now.read.position_rad[neck_yaw] - now.joints[neck_yaw]), 0.0441 * deg);
  }
}

TEST(Plant, ReadsWithTheNoiseOfItsEncoders) {
  PlantConfig config;
  config.encoders.noise_deg = 0.05;
  const auto instants = move(config, 2000, [](int, HeadJointVector&) {});
  double square = 0.0;
  double product = 0.0;  // of neighbours in time
  double last = 0.0;
  for (const Instant& now : instants) {
    const double error = (now.read.position_rad[eyes_tilt] - now.joints[eyes_tilt]) / deg;
    square += error * error;
    product += error * last;
    last = error;
  }
  const double n = static_cast<double>(instants.size());
  std::cout << "noise " << std::sqrt(square / n) << " deg\n";
  EXPECT_NEAR(std::sqrt(square / n), 0.05, 3.0 * 0.05 / std::sqrt(2.0 * n));
  EXPECT_LT(std::abs(product / square), 3.0 / std::sqrt(n));
  const auto same = move(config, 10, [](int, HeadJointVector&) {});
  EXPECT_EQ(same[9].read.position_rad, instants[9].read.position_rad);
}

TEST(Plant, DifferencesItsReadingsForVelocities) {
  PlantConfig config;
  config.encoders = {0.01, 0.005, 10};
  const auto instants = move(config, 500, [](int tick, HeadJointVector& reference) {
    reference[yaw] = 0.05 * std::max(tick - 100, 0) * deg;  // 50 deg/s
  });
  for (std::size_t t = 10; t < instants.size(); ++t) {
    const JointVector moved = instants[t].read.position_rad - instants[t - 10].read.position_rad;
    ASSERT_LT((moved / 0.01 - instants[t].read.velocity_rad_s).cwiseAbs().maxCoeff(), 1e-9);
  }
  // In steady motion it is the speed, but for the noise of two readings over 10 ms.
  EXPECT_NEAR(instants.back().read.velocity_rad_s[neck_yaw] / deg, 50.0, 4.0 * 0.01 * std::sqrt(2.0) / 0.01);
}

/// Back and forth by 5 deg at 10 deg/s.
double triangle_rad(int tick) {
  const int phase = tick % 2000;
  return (phase < 500 ? 0.01 * phase : phase < 1500 ? 10.0 - 0.01 * phase : 0.01 * phase - 20.0) * deg;
}

TEST(Plant, MovesNoJointWhileItsMotorCrossesTheBacklash) {
  PlantConfig config;
  config.neck.backlash_deg = 0.5;
  config.eyes.backlash_deg = 0.3;
  const auto instants = move(config, 4000, [](int tick, HeadJointVector& reference) {
    reference[yaw] = triangle_rad(tick);
    reference[eyes_version - torso_joint_count] = triangle_rad(tick);
  });
  for (const auto& [joint, backlash_deg] : {std::pair{neck_yaw, 0.5}, std::pair{eyes_version, 0.3}}) {
    // The motor turns by the backlash from its reversal until its joint begins to follow.
    std::vector<double> gaps_deg;
    double turned_at = 0.0;
    int direction = 0;
    bool waits = false;
    for (std::size_t t = 1001; t < instants.size(); ++t) {
      const double motor_step =
          instants[t].read.position_rad[joint] - instants[t - 1].read.position_rad[joint];
      const double joint_step = instants[t].joints[joint] - instants[t - 1].joints[joint];
      const int now = motor_step > 0.0 ? 1 : -1;
      if (direction != 0 && now != direction) {
        turned_at = instants[t - 1].read.position_rad[joint];
        waits = true;
      }
      direction = now;
      if (waits && joint_step != 0.0) {
        gaps_deg.push_back(std::abs(instants[t - 1].read.position_rad[joint] - turned_at) / deg);
        waits = false;
      }
    }
    ASSERT_EQ(gaps_deg.size(), 3U);
    for (const double gap_deg : gaps_deg) {
      std::cout << joint_names[joint] << ": " << gap_deg << " deg\n";
      EXPECT_NEAR(gap_deg, backlash_deg, 0.011);  // a tick's motion
    }
  }
}

TEST(Plant, UsesTheJointsNotTheMotorsInImagesAndGroundTruth) {
  WorldConfig config = still_world();
  config.plant.neck.backlash_deg = 1.0;
  World world(config, "", 1);
  MjDataPtr between(mj_makeData(&world.model()));
  HeadJointVector reference = HeadJointVector::Zero();
  reference[yaw] = 10.0 * deg;
  ASSERT_TRUE(world.set_reference(reference));
  const auto heading = [](const Eigen::Isometry3d& pose) {
    return -std::atan2(pose.linear()(1, 2), -pose.linear()(0, 2));  // to the left
  };
  double last = heading(world.root_from_left_cam());
  for (int tick = 0; tick < 300; ++tick) {
    world.step();
    const double now = heading(world.root_from_left_cam());
    const JointVector q = world.joints_rad();
    ASSERT_NEAR(now, q[neck_yaw] - q[eyes_version] - 0.5 * q[eyes_vergence], 1e-4);
    world.show(world.now_us() - 500, *between);
    const double half = heading(World::root_from_camera(*between, world.left_eye_camera()));
    ASSERT_GE(half, last - 2e-5);
    ASSERT_LE(half, now + 2e-5);
    last = now;
  }
  EXPECT_NEAR(world.head_state().position_rad[neck_yaw] - world.joints_rad()[neck_yaw], 0.5 * deg, 2e-5);
}

TEST(Plant, KeepsItsLimitsBehindTheBacklash) {
  PlantConfig config;
  config.neck.backlash_deg = 2.0;
  config.eyes.backlash_deg = 2.0;
  const JointLimits limits = World(still_world(), "", 1).limits();
  double excess_rad = -1.0;
  const auto instants = move(config, 6000, [&](int tick, HeadJointVector& reference) {
    const int corner = tick / 150;
    for (int j = 0; j < head_joint_count; ++j) {
      const int joint = torso_joint_count + j;
      reference[j] = ((corner * 37) >> j) % 2 == 0 ? limits.min_rad[joint] : limits.max_rad[joint];
    }
  });
  for (const Instant& now : instants) {
    excess_rad = std::max(
        {excess_rad, (now.joints - limits.max_rad).maxCoeff(), (limits.min_rad - now.joints).maxCoeff()});
  }
  EXPECT_LT(excess_rad / deg, 0.01);
}

TEST(Plant, SticksUntilTheServoOvercomesItsFriction) {
  // Position error at which a servo sticks, friction over stiffness: neck yaw 0.05 * 14 N m / 240 N m/rad, an eye's pan
  // 0.05 * 1.1 / 14.7.
  for (const auto& [joint, band_rad] :
       {std::pair{neck_yaw, 0.05 * 14.0 / 240.0}, std::pair{eyes_version, 0.05 * 1.1 / 14.7}}) {
    PlantConfig config;
    config.neck.friction_share = config.eyes.friction_share = 0.05;
    const auto moved = [&, joint = joint](double to_rad) {
      const auto instants = move(config, 1000, [&](int, HeadJointVector& reference) {
        reference[joint - torso_joint_count] = to_rad;
      });
      return instants.back().joints[joint] - instants.front().joints[joint];
    };
    const double within = moved(0.9 * band_rad);
    const double beyond = moved(3.0 * band_rad);
    std::cout << joint_names[joint] << ": of a band of " << band_rad / deg << " deg 0.9 move it by "
              << within / band_rad << ", 3 by " << beyond / band_rad << "\n";
    EXPECT_LT(std::abs(within), 0.01 * band_rad);
    // Critically damped, it stops as soon as the servo's torque is below friction.
    EXPECT_NEAR(beyond, 2.0 * band_rad, 0.15 * band_rad);
  }
}

}  // namespace
}  // namespace saccade
