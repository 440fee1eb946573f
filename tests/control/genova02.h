#pragma once

#include <cmath>

#include "core/random.h"
#include "core/units.h"
#include "head/head_state.h"

namespace saccade {

/// The limits of the robot iCubGenova02 in 2016 (robots-configuration), firmware speed cap 1000 deg/s.
inline JointLimits genova02_limits() {
  JointLimits limits;
  limits.min_rad.head<joint_count>() << -20, -30, -50, -30, -20, -45, -30, -30, 0;
  limits.max_rad.head<joint_count>() << 70, 30, 50, 17, 20, 45, 30, 30, 50;
  limits.min_rad *= rad_per_deg;
  limits.max_rad *= rad_per_deg;
  limits.max_speed_rad_s.setConstant(1000.0 * rad_per_deg);
  return limits;
}

/// Uniform within the limits; configuration number `i` of a stream.
inline JointVector random_configuration(const RandomStream& random, std::uint64_t i) {
  const JointLimits limits = genova02_limits();
  JointVector q = JointVector::Zero();
  for (int j = 0; j < joint_count; ++j) {
    q[j] = random.uniform(limits.min_rad[j], limits.max_rad[j], static_cast<std::uint64_t>(j), i);
  }
  return q;
}

}  // namespace saccade
