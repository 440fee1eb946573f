#pragma once

#include <Eigen/Core>
#include <optional>

#include "control/recent_path.h"

namespace saccade {

/// A point that moves straight at constant velocity: its place at t0.
struct StraightPath {
  double t0_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// The line through a path from 0.6 to 0.1 s before its newest average: the last 0.1 s may already be wrong, as when
/// something begins to cover a ball. The fitted velocity v across the line of sight (y, z) is multiplied by
/// v^2 / (v^2 + n^2), where n = 0.03 m/s is its noise; along it (x) it is zero, because the distance of a ball is uncertain.
/// None for less than ten averages, for points that lie farther than 8 mm (root mean square of y, z) from the line, and for
/// velocities above 0.2 m/s.
[[nodiscard]] std::optional<StraightPath> fit_straight_path(const RecentPath& path);

}  // namespace saccade
