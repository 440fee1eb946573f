#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace saccade {

/// Quantiles, means and standard deviations of measured values.

/// The value below which `share` (0..1) of the values lie, linearly interpolated between the two nearest
/// ranks; none of no values. Reorders `values`.
[[nodiscard]] std::optional<double> quantile(std::vector<double>& values, double share);

/// Median and 95th percentile of a quantity; none where nothing was measured.
struct Percentiles {
  std::optional<double> median;
  std::optional<double> p95;
};

[[nodiscard]] Percentiles percentiles_of(std::vector<double> values);

/// Up to this many values, streaming statistics are exact. At 1 kHz these are 4 min 22 s.
inline constexpr std::size_t max_exact_values = std::size_t{1} << 18U;

/// The bin of a finite number on a logarithmic scale: bins are ordered as the numbers are, and one spans 2^-10 of
/// its numbers' magnitude (0.1 %).
[[nodiscard]] std::uint32_t fine_bin(double value);
/// The number in the middle of a bin.
[[nodiscard]] double middle_of_bin(std::uint32_t bin);

/// Quantiles of a stream of values in bounded memory.
///
/// Exact up to `max_exact` values (8 bytes each). Beyond that only counts in bins of fine_bin() are kept, and a
/// quantile is wrong by at most 0.05 % of its magnitude. Independent of the order of the values.
class QuantileCounter {
 public:
  explicit QuantileCounter(std::size_t max_exact = max_exact_values) : max_exact_(max_exact) {}

  /// `value` is finite.
  void add(double value);
  void clear();
  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] bool exact() const { return bins_.empty(); }
  /// As the function quantile().
  [[nodiscard]] std::optional<double> at(double share) const;
  [[nodiscard]] Percentiles percentiles() const;

 private:
  [[nodiscard]] double ranked(std::int64_t rank) const;

  std::size_t max_exact_;
  std::int64_t count_ = 0;
  std::vector<double> values_;
  std::map<std::uint32_t, std::int64_t> bins_;  // instead of values_ once there are more than max_exact_
};

/// Mean and sample standard deviation over several runs, of those that have a value.
struct MeanSd {
  std::size_t count = 0;
  std::optional<double> mean;  ///< none of no values
  std::optional<double> sd;    ///< none of fewer than two
};

[[nodiscard]] MeanSd mean_sd_of(std::span<const std::optional<double>> values);

/// The two-sided p-value of Welch's t test: how often two samples of the same mean differ by at least as much as these do.
/// None where a sample has fewer than two values. Where neither varies: 1 for equal means, otherwise 0.
[[nodiscard]] std::optional<double> welch_p_value(const MeanSd& a, const MeanSd& b);

/// The two-sided p-value of the paired t test for the differences of pairs: how often differences of mean zero have a mean
/// at least as far from it. None of fewer than two. Where they do not vary: 1 if they are zero, otherwise 0.
[[nodiscard]] std::optional<double> paired_p_value(const MeanSd& differences);

}  // namespace saccade
