#pragma once

#include <Eigen/Core>
#include <optional>

#include "control/recent_path.h"

namespace saccade {

/// Gravity in the root frame of a robot that stands upright, m/s^2.
[[nodiscard]] inline Eigen::Vector3d gravity_m_s2() { return {0.0, 0.0, -9.81}; }

/// A point in free flight: its place and velocity at t0.
struct FreeFall {
  double t0_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// The flight that the last 140 ms of a path fit: the acceleration across the line of sight (y, z) is that of gravity
/// within 2.5 m/s^2, its change is below 70 m/s^3, and the points lie within 4 mm (root mean square) of the flight. None if they do not.
[[nodiscard]] std::optional<FreeFall> fit_free_fall(const RecentPath& path);

}  // namespace saccade
