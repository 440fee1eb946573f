#pragma once

namespace saccade {

/// Position, 0 to 1, of a minimum-jerk move at the share u of its duration, u in [0, 1]: velocity and acceleration are 0
/// at both ends. The peak velocity is 15/8 of the mean.
/// Source: Flash and Hogan, Journal of Neuroscience 5(7), 1985.
[[nodiscard]] constexpr double minimum_jerk(double u) { return u * u * u * (10.0 + u * (-15.0 + 6.0 * u)); }

}  // namespace saccade
