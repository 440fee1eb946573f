#include "evaluation/scoring/statistics.h"

#include <algorithm>
#include <bit>
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

Percentiles percentiles_of(std::vector<double> values) {
  return {.median = quantile(values, 0.5), .p95 = quantile(values, 0.95)};
}

namespace {

constexpr unsigned dropped_bits = 42;  // of a double's 64: sign, exponent and 10 bits of the mantissa remain
constexpr std::uint64_t sign_bit = std::uint64_t{1} << 63U;

}  // namespace

std::uint32_t fine_bin(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const std::uint64_t ordered = (bits & sign_bit) != 0 ? ~bits : bits | sign_bit;
  return static_cast<std::uint32_t>(ordered >> dropped_bits);
}

double middle_of_bin(std::uint32_t bin) {
  const std::uint64_t ordered =
      (std::uint64_t{bin} << dropped_bits) + (std::uint64_t{1} << (dropped_bits - 1));
  return std::bit_cast<double>((ordered & sign_bit) != 0 ? ordered & ~sign_bit : ~ordered);
}

void QuantileCounter::add(double value) {
  ++count_;
  if (!exact()) {
    ++bins_[fine_bin(value)];
    return;
  }
  values_.push_back(value);
  if (values_.size() <= max_exact_) return;
  for (const double v : values_) ++bins_[fine_bin(v)];
  values_ = {};
}

void QuantileCounter::clear() {
  count_ = 0;
  values_.clear();
  bins_.clear();
}

double QuantileCounter::ranked(std::int64_t rank) const {
  for (const auto& [bin, count] : bins_) {
    rank -= count;
    if (rank < 0) return middle_of_bin(bin);
  }
  SACCADE_CHECK(false);
  return 0.0;
}

std::optional<double> QuantileCounter::at(double share) const {
  if (exact()) {
    std::vector<double> values = values_;
    return quantile(values, share);
  }
  SACCADE_CHECK(share >= 0.0 && share <= 1.0);
  const double rank = share * static_cast<double>(count_ - 1);
  const double below = std::floor(rank);
  const double lower = ranked(static_cast<std::int64_t>(below));
  if (rank == below) return lower;
  return lower + (rank - below) * (ranked(static_cast<std::int64_t>(below) + 1) - lower);
}

Percentiles QuantileCounter::percentiles() const { return {.median = at(0.5), .p95 = at(0.95)}; }

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

namespace {

/// The regularised incomplete beta function I_x(a, b), by the continued fraction of its definition (DLMF 8.17.22),
/// evaluated from the front (modified Lentz).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - incomplete_beta(b, a, 1.0 - x);  // converges faster there
  constexpr double tiny = 1e-300;
  const auto away_from_zero = [](double value) { return std::abs(value) < tiny ? tiny : value; };
  double c = 1.0;
  double d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
  double fraction = d;
  for (int m = 1; m < 1000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double change = 1.0;
    for (const double term : {even, odd}) {
      d = 1.0 / away_from_zero(1.0 + term * d);
      c = away_from_zero(1.0 + term / c);
      change = c * d;
      fraction *= change;
    }
    if (std::abs(change - 1.0) < 1e-15) break;
  }
  const double log_front =
      a * std::log(x) + b * std::log1p(-x) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b);
  return std::exp(log_front) * fraction / a;
}

/// How often Student's t with `freedom` degrees of freedom has a square of at least `t2`.
double t_p_value(double t2, double freedom) {
  return incomplete_beta(0.5 * freedom, 0.5, freedom / (freedom + t2));
}

}  // namespace

std::optional<double> welch_p_value(const MeanSd& a, const MeanSd& b) {
  if (!a.sd || !b.sd) return std::nullopt;
  const double na = static_cast<double>(a.count);
  const double nb = static_cast<double>(b.count);
  const double va = *a.sd * *a.sd / na;
  const double vb = *b.sd * *b.sd / nb;
  const double difference = *b.mean - *a.mean;
  if (va + vb <= 0.0) return difference == 0.0 ? 1.0 : 0.0;
  const double freedom = (va + vb) * (va + vb) / (va * va / (na - 1.0) + vb * vb / (nb - 1.0));
  return t_p_value(difference * difference / (va + vb), freedom);
}

std::optional<double> paired_p_value(const MeanSd& differences) {
  if (!differences.sd) return std::nullopt;
  const double variance = *differences.sd * *differences.sd;
  if (variance <= 0.0) return *differences.mean == 0.0 ? 1.0 : 0.0;
  const double n = static_cast<double>(differences.count);
  return t_p_value(*differences.mean * *differences.mean * n / variance, n - 1.0);
}

}  // namespace saccade
