#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "evaluation/scoring/statistics.h"

namespace saccade {

/// The recalls for which metrics.json has a precision.
inline constexpr std::array<double, 6> reported_recalls = {0.1, 0.2, 0.3, 0.5, 0.7, 0.9};
inline constexpr std::size_t max_curve_points = 200;

/// Precision and recall of the observations with a score of `threshold` or more.
struct CurvePoint {
  double threshold = 0.0;
  double precision = 0.0;
  double recall = 0.0;
};

/// What follows from a precision-recall curve.
struct CurveSummary {
  /// Sum of precision times recall step over all points, no interpolation.
  double average_precision = 0.0;
  /// At the highest threshold whose recall reaches reported_recalls[i]; none when none does.
  std::array<std::optional<double>, reported_recalls.size()> precision_at_recall;
  /// Every point, or max_curve_points of them evenly spaced by rank with both ends kept.
  std::vector<CurvePoint> points;
};

/// Precision-recall curve of a stream of scored observations in bounded memory.
///
/// Up to `max_exact` observations (16 bytes each) the curve has one point for each distinct score. Beyond that
/// observations are counted in bins of fine_bin(score), and the curve has one point for each bin, at the bin's lowest
/// score: precision and recall of every point stay exact, but points with nearly equal scores (0.1 %) fall together.
class PrecisionRecallCounter {
 public:
  explicit PrecisionRecallCounter(std::size_t max_exact = max_exact_values) : max_exact_(max_exact) {}

  /// `score` is finite.
  void add(double score, bool inlier);
  [[nodiscard]] bool exact() const { return bins_.empty(); }
  /// `chances` is above 0.
  [[nodiscard]] CurveSummary summary(std::int64_t chances) const;

 private:
  struct Bin {
    double lowest = 0.0;
    std::int64_t observations = 0;
    std::int64_t inliers = 0;
  };
  void add_to_bin(double score, bool inlier);
  [[nodiscard]] std::vector<CurvePoint> curve(std::int64_t chances) const;

  std::size_t max_exact_;
  std::vector<std::pair<double, bool>> observations_;
  std::map<std::uint32_t, Bin> bins_;  // instead of observations_ once there are more than max_exact_
};

}  // namespace saccade
