#include "control/bearing.h"

#include <algorithm>
#include <cmath>

namespace saccade {

Bearing bearing_of(const Eigen::Vector3d& p) {
  constexpr double nearest_m = 1e-6;
  const double across = std::max(std::hypot(p.x(), p.z()), nearest_m);
  const double range = std::max(p.norm(), nearest_m);
  return {std::atan2(p.x(), p.z()) * across / range,
          std::atan2(p.y(), across),
          {p.z() / (across * range), 0.0, -p.x() / (across * range)},
          {-p.x() * p.y() / (across * range * range), across / (range * range),
           -p.z() * p.y() / (across * range * range)}};
}

}  // namespace saccade
