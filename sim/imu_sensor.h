#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "core/config.h"
#include "core/random.h"
#include "head/imu_reading.h"

namespace saccade {

/// Errors of the inertial measurement unit in the head.
struct ImuConfig {
  double gyroscope_noise_deg_s = 0.1;               ///< standard deviation, new every millisecond
  std::array<double, 3> gyroscope_bias_deg_s{};     ///< constant
  double accelerometer_noise_m_s2 = 0.02;           ///< standard deviation, new every millisecond
  std::array<double, 3> accelerometer_bias_m_s2{};  ///< constant
  std::int64_t delay_ms = 2;                        ///< from the motion to the reading
};

/// Keys: gyroscope_noise_deg_s, gyroscope_bias_deg_s, accelerometer_noise_m_s2, accelerometer_bias_m_s2, delay_ms.
void describe(FieldVisitor& v, ImuConfig& config);

/// The simulated inertial measurement unit. Angular velocity and acceleration are differences of the true poses at
/// successive milliseconds.
class ImuSensor {
 public:
  /// Throws InputError for a configuration out of range.
  ImuSensor(const ImuConfig& config, std::uint64_t seed, const Eigen::Isometry3d& world_from_imu);

  /// The true pose one millisecond later, at t_us.
  void step(std::int64_t t_us, const Eigen::Isometry3d& world_from_imu);
  /// The newest reading that has arrived.
  [[nodiscard]] const ImuReading& reading() const { return waiting_[count_ % waiting_.size()]; }

 private:
  ImuConfig config_;
  RandomStream random_;
  std::uint64_t count_ = 0;          // of steps
  std::vector<ImuReading> waiting_;  // the last delay_ms readings, a ring
  Eigen::Isometry3d last_;
  Eigen::Vector3d last_velocity_m_s_ = Eigen::Vector3d::Zero();
};

}  // namespace saccade
