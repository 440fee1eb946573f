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
