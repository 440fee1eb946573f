#pragma once

#include <optional>
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

}  // namespace saccade
