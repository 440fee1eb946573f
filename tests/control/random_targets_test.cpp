// Both controllers, both ways to use the eyes, on an ideal plant.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <tuple>

#include "control/ikingaze_controller.h"
#include "control/qp_controller.h"
#include "tests/control/gaze_plant.h"

namespace saccade {
namespace {

class RandomTargets : public testing::TestWithParam<std::tuple<std::string, AimingEyes>> {
 protected:
  [[nodiscard]] static GazeControllerConfig config() {
    GazeControllerConfig config = built_in_controllers().config();
    config.controller = std::get<0>(GetParam());
    config.get<QpConfig>().eyes = config.get<IkinGazeConfig>().eyes = std::get<1>(GetParam());
    return config;
  }
};
INSTANTIATE_TEST_SUITE_P(, RandomTargets,
                         testing::Combine(testing::Values("qp", "ikingaze"),
                                          testing::Values(AimingEyes::both, AimingEyes::left)),
                         [](const auto& name) {
                           return std::get<0>(name.param) + "_with_" +
                                  std::string(word_of(std::get<1>(name.param)));
                         });

TEST_P(RandomTargets, AThousandTargetsNeverViolateTheLimits) {
  const RandomStream random(11, "targets");
  const auto gaze = controller(config());
  const MotionLimits limits = motion_limits(genova02_limits(), {});
  Plant plant(0.0);
  HeadJointVector last_velocity = HeadJointVector::Zero();
  long refused = 0;
  plant.state.position_rad[eyes_vergence] = 1.0 * rad_per_deg;  // out of the margin
  for (std::uint64_t i = 0; i < 1000; ++i) {
    // Anywhere in a cube of 2 m around the head, behind and inside of it too.
    const Eigen::Vector3d target_m(random.uniform(-1, 1, 0, i), random.uniform(-1, 1, 1, i),
                                   random.uniform(-0.65, 1.35, 2, i));
    for (int tick = 0; tick < 150; ++tick) {
      const HeadJointVector before = plant.state.head_position_rad();
      const HeadJointVector reference =
          gaze->step(plant.state, tick == 0 ? std::optional(target_m) : std::nullopt, dt);
      if (tick == 0) refused += gaze->target_status() != TargetStatus::ok;
      ASSERT_FALSE(violates(reference));
      const HeadJointVector velocity = (reference - before) / dt;
      ASSERT_TRUE((velocity.array().abs() <= limits.speed_rad_s.array() + 1e-9).all());
      ASSERT_TRUE(
          ((velocity - last_velocity).array().abs() <= limits.acceleration_rad_s2.array() * dt * (1 + 1e-6))
              .all());
      last_velocity = velocity;
      plant.follow(reference);
      ASSERT_FALSE(violates(plant.state.head_position_rad()));
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_LT(refused, 700);
}

TEST_P(RandomTargets, TheLeftEyeFixatesEveryTargetWithinReach) {
  const RandomStream random(12, "targets");
  const auto gaze = controller(config());
  Plant plant(0.0);
  const bool qp = std::get<0>(GetParam()) == "qp";
  const int targets = qp ? 1000 : 150;
  double worst_deg = 0.0;
  int reached = 0;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(targets); ++i) {
    // What the neck alone can be turned to within 10 deg, so that the eyes' limits leave room.
    const Eigen::Vector3d target_m = seen_at(random.uniform(-50, 50, 0, i), random.uniform(-25, 20, 1, i),
                                             random.uniform(0.25, 0.6, 2, i));
    run(*gaze, plant, target_m, qp ? 1.0 : 2.5);
    const double left_deg = angle_deg(Eye::left, plant.state.position_rad, target_m);
    reached += left_deg < 0.1;
    worst_deg = std::max(worst_deg, left_deg);
  }
  std::printf("%d of %d within 0.1 deg, at worst %.4f deg\n", reached, targets, worst_deg);
  EXPECT_EQ(reached, targets);
}

}  // namespace
}  // namespace saccade
