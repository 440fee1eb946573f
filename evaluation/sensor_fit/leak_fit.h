#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "evaluation/sensor_fit/sensor_recording.h"

namespace saccade {

/// Prior of the leak's parameters: normal distributions of their logarithms.
struct LeakPrior {
  double rate_hz = 0.1;
  double rate_deviation = 2.0;  ///< of the logarithm
  double spread_decades = 0.1;
  double spread_deviation = 1.0;  ///< of the logarithm
};

/// The posterior distribution of the leak's parameters.
struct LeakFit {
  double rate_hz =
      0.0;  ///< median over pixels of the rate that leak alone gives; the posterior's mean logarithm
  double rate_deviation = 0.0;    ///< of the logarithm
  double highest_rate_hz = 0.0;   ///< the posterior has 95 % of its mass below it
  double spread_decades = 0.0;    ///< standard deviation over pixels of the rate's log10
  double spread_deviation = 0.0;  ///< of the logarithm
  std::vector<double>
      events;  ///< of each recording, the expected number of leak events; 0 of those that move
};

/// Leak and its spread from the intervals of scenes at rest, by their likelihood. In constant light shot noise is a Poisson
/// process of both polarities, and every event of a pixel restarts its leakage; so an interval without event ends at the
/// latest with an ON event after the pixel's own leak period. Leak events differ from ON events of shot noise in that no
/// interval of the pixel is longer. Periods are log-normal over the pixels. Uses every other pixel of the sample, as
/// fit_sensor does.
[[nodiscard]] LeakFit fit_leak(std::span<const SensorRecording> recordings, const LeakPrior& prior);

}  // namespace saccade
