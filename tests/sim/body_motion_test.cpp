#include "sim/body_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "core/error.h"
#include "core/units.h"
#include "sim/imu_sensor.h"
#include "sim/world.h"

namespace saccade {
namespace {

BodyMotionConfig yaw_sway(double amplitude_deg, double frequency_hz) {
  BodyMotionConfig motion;
  motion.ramp_s = 0.0;
  motion.yaw = {amplitude_deg, frequency_hz, 0.0};
  return motion;
}

WorldConfig quiet_world() {
  WorldConfig config;
  config.ball.trajectory.sway_m = 0.0;
  return config;
}

TEST(BodyMotion, OscillatesFromItsStartOn) {
  BodyMotionConfig config = yaw_sway(5.0, 0.5);
  config.start_s = 1.0;
  const BodyMotion motion(config);
  EXPECT_EQ(motion.angles_rad(900'000), Eigen::Vector3d::Zero());
  EXPECT_NEAR(motion.angles_rad(1'500'000)[2], 5.0 * rad_per_deg, 1e-12);
  EXPECT_NEAR(motion.angles_rad(2'500'000)[2], -5.0 * rad_per_deg, 1e-12);
}

TEST(BodyMotion, AddsARecordingAndHoldsItsLastValue) {
  const std::string file = testing::TempDir() + "/body_motion.csv";
  // A byte order mark first.
  std::ofstream(file) << "\xEF\xBB\xBFt_us,yaw_deg,pitch_deg,roll_deg\n0,0,0,0\n1000000,10,4,0\n";
  BodyMotionConfig config;
  config.ramp_s = 0.0;
  config.file = file;
  const BodyMotion motion(config);
  EXPECT_NEAR(motion.angles_rad(500'000)[2], 5.0 * rad_per_deg, 1e-12);
  EXPECT_NEAR(motion.angles_rad(500'000)[0], 2.0 * rad_per_deg, 1e-12);
  EXPECT_NEAR(motion.angles_rad(5'000'000)[2], 10.0 * rad_per_deg, 1e-12);
}

TEST(BodyMotion, NamesTheLineOfARecordingWhoseTimeDoesNotGrow) {
  const std::string file = testing::TempDir() + "/body_motion_bad.csv";
  std::ofstream(file) << "t_us,pitch_deg,roll_deg,yaw_deg\n1000,0,0,0\n1000,1,0,0\n";
  BodyMotionConfig config;
  config.file = file;
  try {
    const BodyMotion motion(config);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(":3"), std::string::npos) << error.what();
  }
}

TEST(World, TheTorsoFollowsItsMotionAndTheEncodersReadIt) {
  WorldConfig config = quiet_world();
  config.torso = yaw_sway(5.0, 0.5);
  World world(config, "", 1);
  double largest_deg = 0.0;
  for (int i = 0; i < 2000; ++i) {
    world.step();
    largest_deg = std::max(largest_deg, world.head_state().position_rad[torso_yaw] / rad_per_deg);
  }
  EXPECT_NEAR(largest_deg, 5.0, 0.2);
}

TEST(World, AMovingBaseTurnsTheCamerasAndNoJoint) {
  WorldConfig config = quiet_world();
  config.base = yaw_sway(10.0, 0.25);
  World world(config, "", 1);
  const Eigen::Matrix3d before = world.root_from_left_cam().linear();
  for (int i = 0; i < 1000; ++i) world.step();  // a quarter of a period
  const Eigen::AngleAxisd turn(world.root_from_left_cam().linear() * before.transpose());
  EXPECT_NEAR(turn.angle() / rad_per_deg, 10.0, 0.05);
  EXPECT_LT(turn.axis().z(), -0.99);  // to the right
  EXPECT_LT(world.head_state().position_rad.cwiseAbs().maxCoeff(), 0.2 * rad_per_deg);
}

TEST(World, ABaseWithoutMotionChangesNothing) {
  WorldConfig moving = quiet_world();
  moving.base = BodyMotionConfig{};
  World still(quiet_world(), "", 1);
  World world(moving, "", 1);
  for (int i = 0; i < 200; ++i) {
    still.step();
    world.step();
  }
  EXPECT_EQ(still.joints_rad(), world.joints_rad());
  EXPECT_EQ(still.root_from_left_cam().matrix(), world.root_from_left_cam().matrix());
}

TEST(ImuSensor, MeasuresTheTurnOfTheBaseAndGravityAfterItsDelay) {
  WorldConfig config = quiet_world();
  config.base = yaw_sway(10.0, 0.5);
  config.imu = ImuConfig{0.0, {1.0, 0.0, 0.0}, 0.0, {}, 3};
  World world(config, "", 1);
  for (int i = 0; i < 2000; ++i) world.step();
  const ImuReading& reading = *world.imu_reading();
  EXPECT_EQ(reading.t_us, 1'997'000);
  // At the end of a period the base turns right, about -z, at its highest speed.
  EXPECT_NEAR(reading.angular_velocity_rad_s.z() / rad_per_deg, -2.0 * std::numbers::pi * 0.5 * 10.0, 0.5);
  EXPECT_NEAR(reading.angular_velocity_rad_s.x() / rad_per_deg, 1.0, 0.2);  // the bias
  EXPECT_NEAR(reading.acceleration_m_s2.z(), 9.81, 0.1);
}

}  // namespace
}  // namespace saccade
