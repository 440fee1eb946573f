#pragma once

#include <Eigen/Geometry>
#include <array>

#include "core/units.h"

namespace saccade {

/// A rotation vector (axis times angle) of a configuration in radians.
[[nodiscard]] inline Eigen::Vector3d radians(const std::array<double, 3>& vector_deg) {
  return rad_per_deg * Eigen::Vector3d(vector_deg[0], vector_deg[1], vector_deg[2]);
}

/// The rotation of a rotation vector.
[[nodiscard]] inline Eigen::Quaterniond rotation_of(const Eigen::Vector3d& vector_rad) {
  const double angle_rad = vector_rad.norm();
  if (angle_rad == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, vector_rad / angle_rad));
}

/// The rotation vector of a rotation matrix; its length is in [0, pi] radians.
[[nodiscard]] inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace saccade
