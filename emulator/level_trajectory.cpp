#include "emulator/level_trajectory.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

constexpr double solver_step_us = 0.03;  ///< Newton's last step: the error after it is far below

}  // namespace

double LevelTrajectory::turn_after(double from) const {
  if (amplitude == 0.0) return end_us;
  const double share = slope / (amplitude * rate);  // exp(-rate u) where the derivative is 0
  if (!(share > 1e-300 && share < 1.0)) return end_us;
  const double u = -portable_log(share) / rate;
  return u > from && u < end_us ? u : end_us;
}

double LevelTrajectory::time_of(double target, const LevelPoint& from, const LevelPoint& to) const {
  if (amplitude == 0.0)
    return slope == 0.0 ? to.u_us : std::clamp((target - start) / slope, from.u_us, to.u_us);
  // Newton's method inside a bracket.
  const bool rising = to.level > from.level;
  double low = from.u_us;
  double high = to.u_us;
  double u = low + (high - low) * (target - from.level) / (to.level - from.level);
  for (int i = 0; i < 60; ++i) {
    const double fading = amplitude * portable_exp(-rate * u);
    const double error = target - (start + slope * u + fading);
    const double step = error / (slope - rate * fading);
    if (std::abs(step) < solver_step_us) return std::clamp(u + step, from.u_us, to.u_us);
    ((error > 0.0) == rising ? low : high) = u;
    u = u + step > low && u + step < high ? u + step : 0.5 * (low + high);
  }
  return u;
}

}  // namespace saccade
