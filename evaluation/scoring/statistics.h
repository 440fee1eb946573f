#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace saccade {

/// The value below which `share` (0..1) of the values lie, linearly interpolated between the two nearest
/// ranks; none of no values. Reorders `values`.
[[nodiscard]] std::optional<double> quantile(std::vector<double>& values, double share);

/// How a quantity was distributed; none where nothing was measured.
struct Spread {
  std::optional<double> median;
  std::optional<double> p95;
};

[[nodiscard]] Spread spread_of(std::vector<double> values);

/// Mean and sample standard deviation over several runs, of those that have a value.
struct MeanSd {
  std::size_t count = 0;
  std::optional<double> mean;  ///< none of no values
  std::optional<double> sd;    ///< none of fewer than two
};

[[nodiscard]] MeanSd mean_sd_of(std::span<const std::optional<double>> values);

}  // namespace saccade
