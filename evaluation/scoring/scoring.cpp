#include "evaluation/scoring/scoring.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <string>
#include <tuple>

#include "core/config.h"
#include "core/error.h"

namespace saccade {
namespace {

constexpr std::int64_t bin_us = 100'000;
constexpr std::int64_t simulated_period_us = 1'000;
constexpr std::int64_t lag_step_us = 100;
constexpr int min_lag_steps = -500;
constexpr int max_lag_steps = 2000;
constexpr double least_motion_px = 6.0;
constexpr std::int64_t longest_gap_us = 20'000;

bool has_circle(const TruthRow& row) {
  return std::isfinite(row.circle.x_px) && std::isfinite(row.circle.y_px) && std::isfinite(row.circle.r_px);
}

bool is_chance(const TruthRow& row, Chances chances) {
  return has_circle(row) && (chances == Chances::annotated || row.visible >= chance_visible_share);
}

/// An observation beside the truth of its instant; `truth` is null where there was no chance.
struct Observation {
  const DetectionRow* row = nullptr;
  const TruthRow* truth = nullptr;
  bool inlier = false;

  [[nodiscard]] double distance_px() const {
    return std::hypot(row->circle.x_px - truth->circle.x_px, row->circle.y_px - truth->circle.y_px);
  }
  [[nodiscard]] double radius_error_px() const { return std::abs(row->circle.r_px - truth->circle.r_px); }
};

void check_row(const DetectionRow& row, const DetectionRow* previous) {
  const std::string place = "detections of " + row.detector + " at t_us = " + std::to_string(row.t_us);
  if (!std::isfinite(row.circle.x_px + row.circle.y_px + row.circle.r_px + row.score)) {
    throw InputError(place, "a circle or score that is not finite", "numbers");
  }
  if (previous != nullptr && previous->t_us >= row.t_us) {
    throw InputError(place, "a row not later than the one before", "one row per instant, sorted by time");
  }
}

std::vector<Observation> match(std::span<const TruthRow> truth, std::span<const DetectionRow> detections,
                               std::string_view detector, Chances chances) {
  std::vector<Observation> observations;
  auto at = truth.begin();
  const DetectionRow* previous = nullptr;
  for (const DetectionRow& row : detections) {
    if (row.detector != detector) {
      continue;
    }
    check_row(row, previous);
    previous = &row;
    at = std::find_if(at, truth.end(), [&](const TruthRow& t) { return t.t_us >= row.t_us; });
    const bool chance = at != truth.end() && at->t_us == row.t_us && is_chance(*at, chances);
    Observation observation{.row = &row, .truth = chance ? &*at : nullptr};
    if (chance) {
      observation.inlier = observation.distance_px() <= inlier_distance_px &&
                           observation.radius_error_px() <= inlier_radius_px;
    } else if (chances == Chances::annotated) {
      continue;
    }
    observations.push_back(observation);
  }
  return observations;
}

double ratio(std::int64_t part, std::int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

/// One point per distinct score, by falling score.
std::vector<CurvePoint> full_curve(const std::vector<Observation>& observations, std::int64_t chances) {
  std::vector<std::pair<double, bool>> ranked;
  ranked.reserve(observations.size());
  for (const Observation& o : observations) {
    ranked.emplace_back(o.row->score, o.inlier);
  }
  std::sort(ranked.begin(), ranked.end(), std::greater<>());
  std::vector<CurvePoint> curve;
  std::int64_t inliers = 0;
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    inliers += ranked[i].second ? 1 : 0;
    if (i + 1 == ranked.size() || ranked[i + 1].first != ranked[i].first) {
      curve.push_back({.threshold = ranked[i].first,
                       .precision = ratio(inliers, static_cast<std::int64_t>(i) + 1),
                       .recall = ratio(inliers, chances)});
    }
  }
  return curve;
}

std::vector<CurvePoint> thinned(const std::vector<CurvePoint>& curve) {
  if (curve.size() <= max_curve_points) {
    return curve;
  }
  std::vector<CurvePoint> points;
  for (std::size_t i = 0; i < max_curve_points; ++i) {
    points.push_back(curve[i * (curve.size() - 1) / (max_curve_points - 1)]);
  }
  return points;
}

void score_ranking(const std::vector<Observation>& observations, DetectorScore& score) {
  if (score.chances == 0) {
    return;
  }
  const std::vector<CurvePoint> curve = full_curve(observations, score.chances);
  double area = 0.0;
  double recall = 0.0;
  for (const CurvePoint& point : curve) {
    area += point.precision * (point.recall - recall);
    recall = point.recall;
  }
  score.average_precision = area;
  for (std::size_t i = 0; i < reported_recalls.size(); ++i) {
    const auto reached = std::find_if(curve.begin(), curve.end(),
                                      [&](const CurvePoint& p) { return p.recall >= reported_recalls[i]; });
    if (reached != curve.end()) {
      score.precision_at_recall[i] = reached->precision;
    }
  }
  score.pr_curve = thinned(curve);
}

void score_threshold(const std::vector<Observation>& accepted, DetectorScore& score) {
  std::vector<double> distance_px;
  std::vector<double> radius_px;
  score.observations = static_cast<std::int64_t>(accepted.size());
  for (const Observation& o : accepted) {
    score.inliers += o.inlier ? 1 : 0;
    if (o.truth != nullptr) {
      distance_px.push_back(o.distance_px());
      radius_px.push_back(o.radius_error_px());
    }
  }
  if (score.observations > 0) {
    score.precision = ratio(score.inliers, score.observations);
  }
  if (score.chances > 0) {
    score.recall = ratio(score.inliers, score.chances);
  }
  score.position_error_px = spread_of(std::move(distance_px));
  score.radius_error_px = spread_of(std::move(radius_px));
}

struct RateBin {
  std::int64_t chances = 0;
  std::int64_t inliers = 0;
};

void score_rate(std::span<const TruthRow> truth, const std::vector<Observation>& accepted,
                DetectorScore& score) {
  if (score.chances == 0) {
    return;
  }
  const std::int64_t begin_us = truth.front().t_us;
  const std::int64_t end_us = truth.back().t_us + simulated_period_us;
  const auto bin_of = [&](std::int64_t t_us) { return static_cast<std::size_t>((t_us - begin_us) / bin_us); };
  std::vector<RateBin> bins(bin_of(truth.back().t_us) + 1);
  for (const TruthRow& row : truth) {
    bins[bin_of(row.t_us)].chances += is_chance(row, Chances::simulated) ? 1 : 0;
  }
  for (const Observation& o : accepted) {
    if (o.inlier) {
      ++bins[bin_of(o.row->t_us)].inliers;
    }
  }
  std::int64_t time_us = 0;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (bins[i].chances == 0) {
      continue;
    }
    const std::int64_t start_us = begin_us + static_cast<std::int64_t>(i) * bin_us;
    time_us += std::min(bin_us, end_us - start_us);
    if (start_us + bin_us <= end_us) {
      const double rate_hz = static_cast<double>(bins[i].inliers) * 1e6 / static_cast<double>(bin_us);
      score.peak_rate_hz = std::max(score.peak_rate_hz.value_or(0.0), rate_hz);
    }
  }
  score.mean_rate_hz = static_cast<double>(score.inliers) * 1e6 / static_cast<double>(time_us);
}

/// The true centre as a function of time, piecewise linear, with gaps where there is no circle for long.
class TrueCentre {
 public:
  explicit TrueCentre(std::span<const TruthRow> truth) {
    std::size_t start = 0;
    for (const TruthRow& row : truth) {
      if (!has_circle(row)) {
        start = rows_.size();
        continue;
      }
      if (rows_.size() > start && row.t_us - rows_.back().t_us > longest_gap_us) start = rows_.size();
      if (rows_.size() > start) {
        const Node& last = rows_.back();
        const double distance = std::hypot(row.circle.x_px - last.x_px, row.circle.y_px - last.y_px);
        const auto time_us = static_cast<double>(std::max<std::int64_t>(1, row.t_us - last.t_us));
        max_speed_px_us_ = std::max(max_speed_px_us_, distance / time_us);
      }
      rows_.push_back({row.t_us, start, row.circle.x_px, row.circle.y_px});
    }
  }

  [[nodiscard]] double max_speed_px_us() const { return max_speed_px_us_; }

  /// True when the centre is known at every instant of the closed interval.
  [[nodiscard]] bool knows(std::int64_t from_us, std::int64_t to_us) const {
    const auto after = std::lower_bound(rows_.begin(), rows_.end(), to_us, earlier);
    return after != rows_.end() && rows_[after->stretch_start].t_us <= from_us;
  }

  /// Distance of the observation from the true centre at `t_us`. `hint` carries the place in the table from
  /// call to call; t_us must not go back and must be known.
  [[nodiscard]] double distance_px(const Circle& circle, std::int64_t t_us, std::size_t& hint) const {
    while (rows_[hint].t_us < t_us) {
      ++hint;
    }
    const Node& b = rows_[hint];
    if (b.t_us == t_us) {
      return std::hypot(circle.x_px - b.x_px, circle.y_px - b.y_px);
    }
    const Node& a = rows_[hint - 1];
    const double share = static_cast<double>(t_us - a.t_us) / static_cast<double>(b.t_us - a.t_us);
    return std::hypot(circle.x_px - (a.x_px + share * (b.x_px - a.x_px)),
                      circle.y_px - (a.y_px + share * (b.y_px - a.y_px)));
  }

 private:
  struct Node {
    std::int64_t t_us;
    std::size_t stretch_start;  ///< index of the first row since the last gap
    double x_px;
    double y_px;
  };
  static bool earlier(const Node& node, std::int64_t t_us) { return node.t_us < t_us; }

  std::vector<Node> rows_;
  double max_speed_px_us_ = 0.0;
};

bool truth_moves(std::span<const TruthRow> truth, Chances chances) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (const TruthRow& row : truth) {
    if (is_chance(row, chances)) {
      const Eigen::Vector2d centre(row.circle.x_px, row.circle.y_px);
      low = low.cwiseMin(centre);
      high = high.cwiseMax(centre);
    }
  }
  return (high - low).norm() >= least_motion_px;
}

/// The exact minimum over all shifts without trying most of them: no distance, hence no median, changes
/// faster with the shift than the truth moves.
std::optional<double> lag_ms_of(std::span<const TruthRow> truth, const std::vector<Observation>& accepted,
                                Chances chances) {
  if (!truth_moves(truth, chances)) {
    return std::nullopt;
  }
  const TrueCentre centre(truth);
  std::vector<const DetectionRow*> rows;
  for (const Observation& o : accepted) {
    if (o.truth != nullptr &&
        centre.knows(o.row->t_us - max_lag_steps * lag_step_us, o.row->t_us - min_lag_steps * lag_step_us)) {
      rows.push_back(o.row);
    }
  }
  if (rows.empty()) {
    return std::nullopt;
  }

  std::vector<double> distances_px(rows.size());
  const auto median_px = [&](int steps) {
    std::size_t hint = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      distances_px[i] = centre.distance_px(rows[i]->circle, rows[i]->t_us - steps * lag_step_us, hint);
    }
    return *quantile(distances_px, 0.5);
  };

  struct Stretch {
    double least_px;  ///< no shift in [first, last] has a smaller median
    int first;
    int last;
    bool operator<(const Stretch& other) const { return least_px > other.least_px; }
  };
  std::priority_queue<Stretch> stretches;
  stretches.push({0.0, min_lag_steps, max_lag_steps});
  std::tuple<double, int, int> best{std::numeric_limits<double>::infinity(), 0, 0};  // median, |shift|, shift
  while (!stretches.empty() && stretches.top().least_px <= std::get<0>(best)) {
    const Stretch stretch = stretches.top();
    stretches.pop();
    const int middle = stretch.first + (stretch.last - stretch.first) / 2;
    const double value_px = median_px(middle);
    best = std::min(best, std::tuple{value_px, std::abs(middle), middle});
    const auto push = [&](int first, int last, int farthest) {
      if (first <= last) {
        const double reach_us = static_cast<double>(std::abs(farthest - middle) * lag_step_us);
        // A hair below the bound, for the rounding of the distances.
        stretches.push({value_px - centre.max_speed_px_us() * reach_us * (1.0 + 1e-9) - 1e-9, first, last});
      }
    };
    push(stretch.first, middle - 1, stretch.first);
    push(middle + 1, stretch.last, stretch.last);
  }
  return static_cast<double>(std::get<2>(best)) * static_cast<double>(lag_step_us) / 1000.0;
}

}  // namespace

DetectorScore score_detector(std::span<const TruthRow> truth, std::span<const DetectionRow> detections,
                             std::string_view detector, double threshold, Chances chances) {
  DetectorScore score;
  score.threshold = threshold;
  score.chances =
      std::count_if(truth.begin(), truth.end(), [&](const TruthRow& row) { return is_chance(row, chances); });
  std::vector<Observation> observations = match(truth, detections, detector, chances);
  score_ranking(observations, score);

  std::erase_if(observations, [&](const Observation& o) { return o.row->score < threshold; });
  score_threshold(observations, score);
  if (chances == Chances::simulated) {
    score_rate(truth, observations, score);
  }
  score.lag_ms = lag_ms_of(truth, observations, chances);
  return score;
}

std::vector<std::optional<bool>> found_at_chances(std::span<const TruthRow> truth,
                                                  std::span<const DetectionRow> detections,
                                                  std::string_view detector, double threshold) {
  std::vector<std::optional<bool>> found;
  found.reserve(truth.size());
  for (const TruthRow& row : truth) {
    found.push_back(is_chance(row, Chances::simulated) ? std::optional(false) : std::nullopt);
  }
  for (const Observation& o : match(truth, detections, detector, Chances::simulated)) {
    if (o.inlier && o.row->score >= threshold) {
      found[static_cast<std::size_t>(o.truth - truth.data())] = true;
    }
  }
  return found;
}

std::optional<double> found_rate_hz(std::span<const TruthRow> truth,
                                    std::span<const std::optional<bool>> found, std::int64_t from_us) {
  SACCADE_CHECK(truth.size() == found.size());
  std::int64_t chances = 0;
  std::int64_t right = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i].t_us < from_us || !found[i]) continue;
    ++chances;
    right += *found[i] ? 1 : 0;
  }
  if (chances == 0) return std::nullopt;
  return 1e3 * static_cast<double>(right) / static_cast<double>(chances);
}

}  // namespace saccade
