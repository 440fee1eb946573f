#pragma once

#if __has_include("evaluation/scoring/detector_scorer.h")
#include "evaluation/scoring/detector_scorer.h"
#else
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/scoring/clutter.h"
#include "evaluation/scoring/scoring.h"

namespace saccade {

inline constexpr std::size_t max_exact_values = std::size_t{1} << 18;

/// A detector's best circle at an instant.
struct Observation {
  Circle circle;
  double score = 0.0;
};

/// Scores one detector from everything that was added.
class DetectorScorer {
 public:
  DetectorScorer(std::string detector, double threshold, Chances chances, std::size_t = max_exact_values)
      : detector_(std::move(detector)), threshold_(threshold), chances_(chances) {}

  /// Whether the ball was found; none where the instant is no chance.
  std::optional<bool> add(const TruthRow& truth, const std::optional<Observation>& observation) {
    truth_.push_back(truth);
    if (observation) add(truth.t_us, *observation);
    const bool chance = std::isfinite(truth.circle.x_px) && truth.visible >= chance_visible_share;
    if (!chance) return std::nullopt;
    return observation && observation->score >= threshold_ &&
           std::hypot(observation->circle.x_px - truth.circle.x_px,
                      observation->circle.y_px - truth.circle.y_px) <= inlier_distance_px &&
           std::abs(observation->circle.r_px - truth.circle.r_px) <= inlier_radius_px;
  }
  void add(std::int64_t t_us, const Observation& observation) {
    rows_.push_back({t_us, detector_, observation.circle, observation.score, false});
  }
  [[nodiscard]] DetectorScore score() const {
    return score_detector(truth_, rows_, detector_, threshold_, chances_);
  }

 private:
  std::string detector_;
  double threshold_;
  Chances chances_;
  std::vector<TruthRow> truth_;
  std::vector<DetectionRow> rows_;
};

/// Averages the clutter at one detector's chances.
class ChanceClutter {
 public:
  void add(double visible, double window_share, bool detected) {
    if (!(visible >= chance_visible_share) || !std::isfinite(window_share)) return;
    Mean& mean = detected ? detected_ : missed_;
    mean.sum += window_share;
    ++mean.count;
  }
  [[nodiscard]] DetectorClutter result(std::int64_t clutter_events, std::int64_t inliers) const {
    const auto value = [](const Mean& mean) -> std::optional<double> {
      if (mean.count == 0) return std::nullopt;
      return mean.sum / static_cast<double>(mean.count);
    };
    DetectorClutter clutter{value(detected_), value(missed_), std::nullopt};
    if (inliers > 0)
      clutter.per_detection = static_cast<double>(clutter_events) / static_cast<double>(inliers);
    return clutter;
  }

 private:
  struct Mean {
    double sum = 0.0;
    std::int64_t count = 0;
  };
  Mean detected_;
  Mean missed_;
};

/// How often per second a detector finds the ball.
class FollowingRate {
 public:
  void add(std::int64_t t_us, std::optional<bool> found) {
    if (found) found_.emplace_back(t_us, *found);
  }
  [[nodiscard]] std::optional<double> rate_hz(std::int64_t from_us) const {
    std::int64_t chances = 0;
    std::int64_t found = 0;
    for (const auto& [t_us, is_found] : found_) {
      if (t_us < from_us) continue;
      ++chances;
      found += is_found ? 1 : 0;
    }
    if (chances == 0) return std::nullopt;
    return 1e3 * static_cast<double>(found) / static_cast<double>(chances);
  }

 private:
  std::vector<std::pair<std::int64_t, bool>> found_;
};

}  // namespace saccade
#endif
