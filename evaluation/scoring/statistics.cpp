#include "evaluation/scoring/statistics.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace saccade {

std::optional<double> quantile(std::vector<double>& values, double share) {
  SACCADE_CHECK(share >= 0.0 && share <= 1.0);
  if (values.empty()) {
    return std::nullopt;
  }
  const double rank = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::ptrdiff_t>(std::floor(rank));
  const auto lower = values.begin() + below;
  std::nth_element(values.begin(), lower, values.end());
  const double fraction = rank - std::floor(rank);
  if (fraction == 0.0) {
    return *lower;
  }
  const double upper = *std::min_element(lower + 1, values.end());
  return *lower + fraction * (upper - *lower);
}

Spread spread_of(std::vector<double> values) {
  return {.median = quantile(values, 0.5), .p95 = quantile(values, 0.95)};
}

MeanSd mean_sd_of(std::span<const std::optional<double>> values) {
  MeanSd result;
  double sum = 0.0;
  for (const auto& value : values) {
    if (value) {
      sum += *value;
      ++result.count;
    }
  }
  if (result.count == 0) {
    return result;
  }
  const auto count = static_cast<double>(result.count);
  const double mean = sum / count;
  result.mean = mean;
  if (result.count > 1) {
    double squares = 0.0;
    for (const auto& value : values) {
      squares += value ? (*value - mean) * (*value - mean) : 0.0;
    }
    result.sd = std::sqrt(squares / (count - 1.0));
  }
  return result;
}

}  // namespace saccade
