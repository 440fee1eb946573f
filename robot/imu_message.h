#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "head/imu_reading.h"

namespace saccade {

/// Numbers in a message of an iCub's inertial sensor (PORT `/icub/inertial`): three angles of its orientation (deg), then along
/// x, y, z of the sensor the specific force (m/s^2), the angular velocity (deg/s) and the magnetic field.
inline constexpr int imu_message_numbers = 12;

/// The reading in such a message; none if there are fewer numbers or one of those used is not finite. `t_us`: its time.
/// `head_from_imu`: orientation of the sensor in the frame of ImuReading (HeadModel::head_from_imu).
[[nodiscard]] std::optional<ImuReading> imu_reading_of(std::span<const double> values, std::int64_t t_us,
                                                       const Eigen::Matrix3d& head_from_imu);

}  // namespace saccade
