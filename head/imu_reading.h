#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace saccade {

/// A reading of the inertial measurement unit in the head.
///
/// Frame: fixed to the part of the head that the neck turns; parallel to the root frame (x backward, y right, z up) while
/// the joints of torso and neck are 0 and the base is level. Its origin is the point on the axis of neck yaw where the
/// neck ends.
struct ImuReading {
  std::int64_t t_us = 0;  ///< clock of the events
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  /// Acceleration less gravity (specific force): (0, 0, 9.81) in a level head at rest.
  Eigen::Vector3d acceleration_m_s2 = Eigen::Vector3d::Zero();
};

}  // namespace saccade
