#include "control/stabilisation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "control/head_kinematics.h"
#include "core/units.h"
#include "tests/control/gaze_plant.h"

namespace saccade {
namespace {

HeadState turning(double torso_yaw_rad_s, double neck_yaw_rad_s) {
  HeadState state;
  state.velocity_rad_s[torso_yaw] = torso_yaw_rad_s;
  state.velocity_rad_s[neck_yaw] = neck_yaw_rad_s;
  return state;
}

TEST(Stabiliser, TakesTheMotionOfTheNeckOutOfWhatTheGyroscopeMeasures) {
  Stabiliser stabiliser({false, true}, default_head());
  ImuReading imu;
  imu.angular_velocity_rad_s = {0.0, 0.0, 0.5 - 0.2};  // neck + turns left, about +z; torso + right, about -z
  const BodyRates& both = stabiliser.update(turning(0.2, 0.5), &imu, 0.0, 1e-3);
  EXPECT_LT((both.base_rad_s - Eigen::Vector3d(0.0, 0.0, -0.2)).norm(), 1e-9);
  EXPECT_TRUE(
      both.level_from_root.isApprox(Eigen::Quaterniond::Identity(), 1e-12));  // the base does not turn
}

TEST(Stabiliser, CountsTheTorsoOnceWithBothMeasurements) {
  Stabiliser stabiliser({true, true}, default_head());
  ImuReading imu;
  imu.angular_velocity_rad_s = {0.0, 0.0, -0.2 + 0.1};
  const BodyRates& rates = stabiliser.update(turning(0.2, 0.0), &imu, 0.0, 1e-3);
  EXPECT_NEAR(rates.torso_rad_s[torso_yaw], 0.2, 1e-12);
  EXPECT_LT((rates.base_rad_s - Eigen::Vector3d(0.0, 0.0, 0.1)).norm(), 1e-9);
}

TEST(Stabiliser, IgnoresAReadingThatIsNotFinite) {
  Stabiliser stabiliser({true, true}, default_head());
  ImuReading imu;
  imu.angular_velocity_rad_s.setConstant(std::nan(""));
  EXPECT_TRUE(stabiliser.update(turning(0.2, 0.0), &imu, 0.0, 1e-3).base_rad_s.isZero());
}

/// The rates after 0.2 s in which the image shows `seen_root_rad_s` (root frame) every 4 ms.
BodyRates watched(const StabilisationConfig& config, const HeadState& state,
                  const Eigen::Vector3d& seen_root_rad_s, double gyroscope_z_rad_s = 0.0) {
  Stabiliser stabiliser(config, default_head());
  const Eigen::Matrix3d eye_from_root = HeadKinematics(default_head()->chain, JointVector::Zero())
                                            .root_from_eye(Eye::left)
                                            .linear()
                                            .transpose();
  ImuReading imu;
  imu.angular_velocity_rad_s = {0.0, 0.0, gyroscope_z_rad_s};
  BodyRates rates;
  for (int i = 0; i < 200; ++i) {
    std::optional<Eigen::Vector3d> seen;
    if (i % 4 == 0) seen = eye_from_root * seen_root_rad_s;
    rates = stabiliser.update(state, &imu, 0.0, 1e-3, seen);
  }
  return rates;
}

TEST(Stabiliser, TakesTheMotionOfNeckAndTorsoOutOfWhatTheImageShows) {
  // Neck + turns left, about +z; torso + right, about -z; the base turns at 0.1 rad/s about z.
  const HeadState state = turning(0.2, 0.5);
  const Eigen::Vector3d seen(0.0, 0.0, 0.5 - 0.2 + 0.1);
  EXPECT_LT(
      (watched({false, false, true}, state, seen).base_rad_s - Eigen::Vector3d(0.0, 0.0, 0.1 - 0.2)).norm(),
      1e-6);
  const BodyRates both = watched({true, false, true}, state, seen);
  EXPECT_LT((both.base_rad_s - Eigen::Vector3d(0.0, 0.0, 0.1)).norm(), 1e-6);
  EXPECT_NEAR(both.torso_rad_s[torso_yaw], 0.2, 1e-12);
}

TEST(Stabiliser, TheImageCorrectsTheBiasOfTheGyroscope) {
  const BodyRates rates =
      watched({false, true, true}, turning(0.0, 0.0), Eigen::Vector3d(0.0, 0.0, 0.2), 0.2 + 0.05);
  EXPECT_LT((rates.base_rad_s - Eigen::Vector3d(0.0, 0.0, 0.2)).norm(), 1e-6);
}

TEST(Stabiliser, AnImageWithoutAgreementIsNoMeasurementWhileTheNeckTurns) {
  const BodyRates rates = watched({false, false, true}, turning(0.0, 0.5), Eigen::Vector3d::Zero());
  EXPECT_TRUE(rates.base_rad_s.isZero());
}

TEST(Stabiliser, WhatTheImageShowedFadesWithoutAFurtherMeasurement) {
  Stabiliser stabiliser({false, false, true}, default_head());
  BodyRates rates;
  const auto run = [&](int ticks, bool sees) {
    for (int i = 0; i < ticks; ++i) {
      rates = stabiliser.update(
          {}, nullptr, 0.0, 1e-3,
          sees && i % 4 == 0 ? std::optional(Eigen::Vector3d(0.0, -0.3, 0.0)) : std::nullopt);
    }
  };
  run(200, true);
  EXPECT_NEAR(rates.base_rad_s.norm(), 0.3, 1e-6);
  run(500, false);
  EXPECT_LT(rates.base_rad_s.norm(), 0.01);
}

/// The largest gaze error while the torso turns at 1 Hz, 31 deg/s, and the target rests; the plant is ideal.
double worst_error_deg(const char* name, const StabilisationConfig& config) {
  GazeControllerConfig gaze_config = built_in_controllers().config();
  gaze_config.controller = name;
  const auto gaze = controller(gaze_config);
  Stabiliser stabiliser(config, default_head());
  Plant plant(0.0);
  const Eigen::Vector3d target = seen_at(5.0, 3.0, 0.45);
  double worst_deg = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double t_s = i * dt;
    const double w = 2.0 * std::numbers::pi;
    plant.state.position_rad[torso_yaw] = 5.0 * rad_per_deg * std::sin(w * t_s);
    plant.state.velocity_rad_s[torso_yaw] = 5.0 * rad_per_deg * w * std::cos(w * t_s);
    ImuReading imu;
    imu.angular_velocity_rad_s = Eigen::Vector3d(
        0.0, 0.0, plant.state.velocity_rad_s[neck_yaw] - plant.state.velocity_rad_s[torso_yaw]);
    gaze->set_body_rates(stabiliser.update(plant.state, &imu, 0.0, dt));
    plant.follow(gaze->step(plant.state, target, dt));
    if (i > 3000) worst_deg = std::max(worst_deg, angle_deg(Eye::left, plant.state.position_rad, target));
  }
  return worst_deg;
}

TEST(Stabilisation, TheTorsosVelocityKeepsTheGazeOnARestingTarget) {
  const double off_deg = worst_error_deg("qp", {});
  const double on_deg = worst_error_deg("qp", {true, false});
  const double gyroscope_deg = worst_error_deg("qp", {false, true});
  std::printf("qp: %.2f deg without, %.2f deg with the torso, %.2f deg with the gyroscope\n", off_deg, on_deg,
              gyroscope_deg);
  EXPECT_GT(off_deg, 1.0);
  EXPECT_LT(on_deg, 0.1 * off_deg);
  EXPECT_LT(gyroscope_deg, 0.2 * off_deg);
}

TEST(Stabilisation, ReducesTheErrorOfIkingazeToo) {
  EXPECT_LT(worst_error_deg("ikingaze", {true, false}), 0.7 * worst_error_deg("ikingaze", {}));
}

}  // namespace
}  // namespace saccade
