#pragma once

#include <Eigen/Core>

namespace saccade {

/// The direction of a point in the frame of an eye (x right, y down, z forward): two angles that are 0 on the optical
/// axis, and their derivatives by the point.
struct Bearing {
  double azimuth_rad;                     ///< to the right, measured on the great circle through the point
  double elevation_rad;                   ///< down
  Eigen::RowVector3d azimuth_by_point;    ///< rad/m
  Eigen::RowVector3d elevation_by_point;  ///< rad/m
};

/// The bearing of the point p, m. Derivatives are finite everywhere, also in the eye and straight above it.
[[nodiscard]] Bearing bearing_of(const Eigen::Vector3d& p);

}  // namespace saccade
