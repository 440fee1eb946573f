#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace saccade {

/// A pixel before a scene at rest whose photoreceptor makes Gaussian noise: white noise behind a low-pass of first order
/// (an Ornstein-Uhlenbeck process). Thresholds are in standard deviations of that noise: events depend on nothing else, so no
/// still scene tells threshold and noise apart.
struct StillNoise {
  double on = 4.0, off = 4.0;  ///< contrast threshold / standard deviation of the noise, 1 to largest_ratio
  double time_constant_s = 1e-3;  ///< of the low-pass: 1 / (2 pi cutoff)
  double refractory_s = 5e-4;     ///< the reference is the level at its end
  double leak_hz = 0.1;           ///< ON events of leak alone: the reference falls by `on` in 1 / leak_hz

  static constexpr double largest_ratio = 9.5;  ///< beyond it noise makes no event
};

/// An event and the next one of its pixel.
enum class Succession : std::size_t { on_on, on_off, off_on, off_off };
constexpr std::size_t successions = 4;
[[nodiscard]] constexpr std::size_t succession_of(bool first_on, bool next_on) {
  return (first_on ? 0U : 2U) + (next_on ? 0U : 1U);
}

/// What such a pixel does in the long run.
struct StillRates {
  double on_hz = 0.0, off_hz = 0.0;
  /// Intervals per second that end in a bin, of each succession.
  std::array<std::vector<double>, successions> intervals_hz;
};

/// `edges_s`: of the bins of intervals, ascending. Solves the passage of the noise to the thresholds on a grid of levels for
/// every reference, by eigenvectors, and then the chain of references from event to event. Errors of a few percent of
/// a rate, below 1 % of a ratio (tests/evaluation/sensor_fit/still_fit_test.cpp).
[[nodiscard]] StillRates still_rates(const StillNoise& noise, std::span<const double> edges_s);

}  // namespace saccade
