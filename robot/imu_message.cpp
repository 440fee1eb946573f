#include "robot/imu_message.h"

#include "core/units.h"

namespace saccade {

std::optional<ImuReading> imu_reading_of(std::span<const double> values, std::int64_t t_us,
                                         const Eigen::Matrix3d& head_from_imu) {
  if (std::ssize(values) < imu_message_numbers) return std::nullopt;
  const Eigen::Vector3d acceleration(values[3], values[4], values[5]);
  const Eigen::Vector3d turn_deg_s(values[6], values[7], values[8]);
  if (!acceleration.allFinite() || !turn_deg_s.allFinite()) return std::nullopt;
  return ImuReading{t_us, head_from_imu * turn_deg_s * rad_per_deg, head_from_imu * acceleration};
}

}  // namespace saccade
