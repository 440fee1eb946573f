#include "robot/imu_message.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <numbers>

namespace saccade {
namespace {

TEST(ImuMessage, TheFourthToNinthNumbersAreAccelerationAndAngularVelocityInDegrees) {
  const std::array<double, 12> message = {10, 20, 30, 0.5, -0.25, 9.75, 90, 0, -180, 1, 2, 3};
  const auto reading = imu_reading_of(message, 77, Eigen::Matrix3d::Identity());
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->t_us, 77);
  EXPECT_TRUE(reading->acceleration_m_s2.isApprox(Eigen::Vector3d(0.5, -0.25, 9.75)));
  EXPECT_TRUE(reading->angular_velocity_rad_s.isApprox(
      Eigen::Vector3d(std::numbers::pi / 2, 0.0, -std::numbers::pi)));
}

TEST(ImuMessage, ASensorThatIsMountedUpsideDownIsTurnedIntoTheFrameOfTheHead) {
  Eigen::Matrix3d head_from_imu;
  head_from_imu << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const std::array<double, 12> message = {0, 0, 0, 0, 0, -9.81, 0, 0, 45, 0, 0, 0};
  const auto reading = imu_reading_of(message, 0, head_from_imu);
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->acceleration_m_s2.z(), 9.81, 1e-12);
  EXPECT_NEAR(reading->angular_velocity_rad_s.z(), -std::numbers::pi / 4, 1e-12);
}

TEST(ImuMessage, AShortMessageAndNumbersThatAreNotFiniteAreNoReading) {
  std::array<double, 12> message{};
  EXPECT_FALSE(imu_reading_of(std::span(message).first(11), 0, Eigen::Matrix3d::Identity()));
  EXPECT_TRUE(imu_reading_of(message, 0, Eigen::Matrix3d::Identity()));
  message[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(imu_reading_of(message, 0, Eigen::Matrix3d::Identity()));
}

}  // namespace
}  // namespace saccade
