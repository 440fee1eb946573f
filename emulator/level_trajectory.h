#pragma once

#include "core/portable_math.h"

namespace saccade {

/// A point of a LevelTrajectory.
struct LevelPoint {
  double u_us;
  double level;
};

/// The output of a pixel's photoreceptor between two images, with leakage:
/// level(u) = start + slope u + amplitude exp(-rate u), u in microseconds since the first of the two.
struct LevelTrajectory {
  double start, slope, amplitude, rate;
  double level;   ///< at u = 0
  double end_us;  ///< u of the second image
  double end;     ///< the level there

  [[nodiscard]] double at(double u) const {
    if (u >= end_us) return end;
    const double line = start + slope * u;
    return amplitude == 0.0 ? line : line + amplitude * portable_exp(-rate * u);
  }
  /// The turning point inside (from, end_us), or end_us.
  [[nodiscard]] double turn_after(double from) const;
  /// The u in (from, to] at which the level reaches `target`. It is monotone between the two and passes the target.
  [[nodiscard]] double time_of(double target, const LevelPoint& from, const LevelPoint& to) const;
};

}  // namespace saccade
