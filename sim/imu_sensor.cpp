#include "sim/imu_sensor.h"

#include "core/units.h"

namespace saccade {
namespace {

constexpr double imu_tick_s = 1e-3;
constexpr double standard_gravity_m_s2 = 9.81;

}  // namespace

void describe(FieldVisitor& v, ImuConfig& c) {
  v.real("gyroscope_noise_deg_s", c.gyroscope_noise_deg_s, {0.0, 100.0},
         "standard deviation of an angular velocity, new every millisecond");
  v.reals("gyroscope_bias_deg_s", c.gyroscope_bias_deg_s, {-100.0, 100.0},
          "constant error of the angular velocity about x, y, z");
  v.real("accelerometer_noise_m_s2", c.accelerometer_noise_m_s2, {0.0, 100.0},
         "standard deviation of an acceleration, new every millisecond");
  v.reals("accelerometer_bias_m_s2", c.accelerometer_bias_m_s2, {-20.0, 20.0},
          "constant error of the acceleration along x, y, z");
  v.integer("delay_ms", c.delay_ms, {0, 200}, "time from the motion to the arrival of its reading");
}

ImuSensor::ImuSensor(const ImuConfig& config, std::uint64_t seed, const Eigen::Isometry3d& world_from_imu)
    : config_(config), random_(seed, "sim/imu"), last_(world_from_imu) {
  check_config("imu", config);
  ImuReading rest;
  rest.acceleration_m_s2 =
      world_from_imu.linear().transpose() * Eigen::Vector3d(0.0, 0.0, standard_gravity_m_s2);
  waiting_.assign(static_cast<std::size_t>(config.delay_ms) + 1, rest);
}

void ImuSensor::step(std::int64_t t_us, const Eigen::Isometry3d& world_from_imu) {
  const Eigen::AngleAxisd turn(last_.linear().transpose() * world_from_imu.linear());
  const Eigen::Vector3d velocity_m_s = (world_from_imu.translation() - last_.translation()) / imu_tick_s;
  const Eigen::Vector3d acceleration = (velocity_m_s - last_velocity_m_s_) / imu_tick_s;
  last_ = world_from_imu;
  last_velocity_m_s_ = velocity_m_s;

  ImuReading& next = waiting_[count_ % waiting_.size()];
  next.t_us = t_us;
  next.angular_velocity_rad_s = turn.angle() / imu_tick_s * turn.axis();
  next.acceleration_m_s2 =
      world_from_imu.linear().transpose() * (acceleration + Eigen::Vector3d(0.0, 0.0, standard_gravity_m_s2));
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    next.angular_velocity_rad_s[row] +=
        rad_per_deg *
        (config_.gyroscope_bias_deg_s[i] + config_.gyroscope_noise_deg_s * random_.normal(i, count_));
    next.acceleration_m_s2[row] +=
        config_.accelerometer_bias_m_s2[i] + config_.accelerometer_noise_m_s2 * random_.normal(3 + i, count_);
  }
  ++count_;
}

}  // namespace saccade
