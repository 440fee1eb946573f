#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "core/camera.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {

/// Whether a detector's score is a probability, and its covariance the spread of its errors.

inline constexpr std::size_t reliability_bins = 10;

/// Observations with a score in one tenth of [0, 1], and how many of them are inliers.
struct ReliabilityBin {
  std::int64_t observations = 0;
  std::int64_t inliers = 0;
  double mean_score = 0.0;  ///< of the observations

  [[nodiscard]] std::optional<double> inlier_share() const;  ///< none without observations
};
/// Bin i holds the scores in [i / 10, (i + 1) / 10), the last one 1 too.
using Reliability = std::array<ReliabilityBin, reliability_bins>;

/// The reliability of a stream of scored observations, in fixed memory.
class ReliabilityCounter {
 public:
  /// `score` is finite.
  void add(double score, bool inlier);
  /// None without observations, and where a score lies outside [0, 1]: it is no probability.
  [[nodiscard]] std::optional<Reliability> result() const;

 private:
  Reliability bins_;
  bool outside_ = false;
  bool any_ = false;
};

/// 95 % of a chi-squared variable with three degrees of freedom lie below.
inline constexpr double nees_bound = 7.81;

/// Normalised estimation error squared, e' C^-1 e, of (x, y, r). None unless the covariance is positive definite.
[[nodiscard]] std::optional<double> nees_of(const Circle& circle, const Eigen::Matrix3d& covariance_px2,
                                            const Circle& truth);

/// NEES of the inliers whose covariance is known.
struct Nees {
  std::int64_t count = 0;
  double below_bound = 0.0;  ///< share of them below nees_bound
  double median = 0.0;
};

/// The NEES of a stream of inliers, in bounded memory (QuantileCounter).
class NeesCounter {
 public:
  explicit NeesCounter(std::size_t max_exact = max_exact_values) : values_(max_exact) {}

  void add(const std::optional<double>& nees);
  [[nodiscard]] bool exact() const { return values_.exact(); }
  /// None where no value was known.
  [[nodiscard]] std::optional<Nees> result() const;

 private:
  QuantileCounter values_;
  std::int64_t below_ = 0;
};

}  // namespace saccade
