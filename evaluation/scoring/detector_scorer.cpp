#include "evaluation/scoring/detector_scorer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace saccade {
namespace {

constexpr std::int64_t bin_us = 100'000;
constexpr std::int64_t simulated_period_us = 1'000;
constexpr std::int64_t instants_per_min = 60'000;
constexpr std::int64_t alarm_gap_us = 100'000;
constexpr std::int64_t longest_gap_us = 20'000;
constexpr double least_motion_px = 6.0;
constexpr double least_speed_px_s = 30.0;
constexpr double infinity = std::numeric_limits<double>::infinity();

double ratio(std::int64_t part, std::int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

double distance_px(const Circle& a, const Circle& b) { return std::hypot(a.x_px - b.x_px, a.y_px - b.y_px); }
double radius_error_px(const Circle& a, const Circle& b) { return std::abs(a.r_px - b.r_px); }

}  // namespace

bool has_circle(const TruthRow& row) {
  return std::isfinite(row.circle.x_px) && std::isfinite(row.circle.y_px) && std::isfinite(row.circle.r_px);
}

bool is_chance(const TruthRow& row) { return has_circle(row) && row.visible >= chance_visible_share; }

bool counts(const TruthRow& row, Chances chances) {
  if (is_chance(row)) return true;
  // An annotated ball without a circle may be anywhere.
  return row.visible == 0.0 || (chances == Chances::simulated && !has_circle(row));
}

bool is_inlier(const Circle& circle, const Circle& truth) {
  return distance_px(circle, truth) <= inlier_distance_px &&
         radius_error_px(circle, truth) <= inlier_radius_px;
}

DetectorScorer::DetectorScorer(std::string detector, double threshold, Chances chances, std::size_t max_exact)
    : detector_(std::move(detector)),
      threshold_(threshold),
      kind_(chances),
      ranking_(max_exact),
      distance_px_(max_exact),
      radius_error_px_(max_exact),
      lag_(max_exact),
      nees_(max_exact),
      lowest_{infinity, infinity, 0.0},
      highest_{-infinity, -infinity, 0.0},
      speed_px_s_(max_exact) {}

void DetectorScorer::check(std::int64_t t_us, const Observation& observation) {
  const auto place = [&] { return "detections of " + detector_ + " at t_us = " + std::to_string(t_us); };
  const Circle& c = observation.circle;
  if (!std::isfinite(c.x_px + c.y_px + c.r_px + observation.score)) {
    throw InputError(place(), "a circle or score that is not finite", "numbers");
  }
  if (last_observation_us_ >= t_us) {
    throw InputError(place(), "a row not later than the one before", "one row per instant, sorted by time");
  }
  last_observation_us_ = t_us;
}

/// `inlier_of`: the true circle; null for a false observation.
void DetectorScorer::count(const Observation& observation, const Circle* inlier_of) {
  const bool inlier = inlier_of != nullptr;
  ranking_.add(observation.score, inlier);
  reliability_.add(observation.score, inlier);
  if (!accepts(observation)) return;
  ++observations_;
  if (!inlier) return;
  ++inliers_;
  nees_.add(nees_of(observation.circle, observation.covariance_px2, *inlier_of));
}

void DetectorScorer::count_instant(std::int64_t t_us, const std::optional<Observation>& observation) {
  ++instants_;
  if (!accepts(observation)) return;
  ++alarm_instants_;
  if (!last_alarm_us_ || t_us - *last_alarm_us_ >= alarm_gap_us) ++alarms_;
  last_alarm_us_ = t_us;
}

/// How far and how fast the true centre moves at the chances.
void DetectorScorer::follow(const TruthRow& truth) {
  lowest_ = {std::min(lowest_.x_px, truth.circle.x_px), std::min(lowest_.y_px, truth.circle.y_px), 0.0};
  highest_ = {std::max(highest_.x_px, truth.circle.x_px), std::max(highest_.y_px, truth.circle.y_px), 0.0};
  const std::int64_t gap_us = last_chance_ ? truth.t_us - last_chance_->t_us : 0;
  if (gap_us > 0 && gap_us <= longest_gap_us)
    speed_px_s_.add(distance_px(truth.circle, last_chance_->circle) * 1e6 / static_cast<double>(gap_us));
  last_chance_ = truth;
}

bool DetectorScorer::moves() const {
  return chances_ > 0 && distance_px(highest_, lowest_) >= least_motion_px &&
         speed_px_s_.at(0.5).value_or(0.0) >= least_speed_px_s;
}

std::optional<bool> DetectorScorer::add(const TruthRow& truth,
                                        const std::optional<Observation>& observation) {
  if (observation) check(truth.t_us, *observation);
  const bool chance = is_chance(truth);
  const bool accepted = accepts(observation);
  const bool inlier = chance && observation && is_inlier(observation->circle, truth.circle);
  ball_ |= has_circle(truth);
  no_circle_ |= std::isfinite(truth.circle.x_px) && std::isnan(truth.circle.r_px);
  count_instant(truth.t_us, observation);
  if (chance) {
    ++chances_;
    follow(truth);
    if (accepted) {
      distance_px_.add(distance_px(observation->circle, truth.circle));
      radius_error_px_.add(radius_error_px(observation->circle, truth.circle));
    }
  }
  if (observation && counts(truth, kind_)) count(*observation, inlier ? &truth.circle : nullptr);
  lag_.add(truth.t_us, has_circle(truth) ? std::optional(truth.circle) : std::nullopt,
           chance && accepted ? std::optional(observation->circle) : std::nullopt);
  if (kind_ == Chances::simulated) rate_.add(truth.t_us, chance, inlier && accepted);
  return chance ? std::optional(inlier && accepted) : std::nullopt;
}

void DetectorScorer::add(std::int64_t t_us, const std::optional<Observation>& observation) {
  count_instant(t_us, observation);
  if (!observation) return;
  check(t_us, *observation);
  if (kind_ == Chances::simulated) count(*observation, nullptr);
}

DetectorScore DetectorScorer::score() const {
  DetectorScore score;
  score.threshold = threshold_;
  if (no_circle_ && !ball_) return score;  // nothing to compare circles with
  score.chances = chances_;
  score.observations = observations_;
  score.inliers = inliers_;
  score.exact = ranking_.exact() && distance_px_.exact() && lag_.exact();
  score.reliability = reliability_.result();
  const bool has_threshold = !std::isnan(threshold_);
  if (chances_ > 0) {
    CurveSummary curve = ranking_.summary(chances_);
    score.average_precision = curve.average_precision;
    score.precision_at_recall = curve.precision_at_recall;
    score.pr_curve = std::move(curve.points);
  }
  if (!has_threshold) return score;
  if (chances_ > 0) {
    score.recall = ratio(inliers_, chances_);
    if (kind_ == Chances::simulated) rate_.write(score);
  }
  if (observations_ > 0) score.precision = ratio(inliers_, observations_);
  score.position_error_px = distance_px_.percentiles();
  score.radius_error_px = radius_error_px_.percentiles();
  if (moves()) score.lag_ms = lag_.lag_ms();
  if (kind_ == Chances::simulated && !ball_ && instants_ > 0) {
    score.alarm_ratio = ratio(alarm_instants_, instants_);
    score.alarms_per_min = ratio(alarms_ * instants_per_min, instants_);
  }
  score.nees = nees_.result();
  return score;
}

void DetectorScorer::Rate::add(std::int64_t t_us, bool chance, bool found) {
  if (!started_) begin_us_ = t_us;
  started_ = true;
  const std::int64_t bin = (t_us - begin_us_) / bin_us;
  if (bin != bin_) {
    close_bin();
    bin_ = bin;
  }
  last_us_ = t_us;
  bin_chances_ += chance ? 1 : 0;
  bin_inliers_ += found ? 1 : 0;
}

/// A bin that another one follows is full.
void DetectorScorer::Rate::close_bin() {
  if (bin_chances_ > 0) {
    time_us_ += bin_us;
    const double rate_hz = static_cast<double>(bin_inliers_) * 1e6 / static_cast<double>(bin_us);
    peak_hz_ = std::max(peak_hz_.value_or(0.0), rate_hz);
  }
  bin_chances_ = 0;
  bin_inliers_ = 0;
}

void DetectorScorer::Rate::write(DetectorScore& score) const {
  Rate all = *this;
  const std::int64_t part_us = last_us_ + simulated_period_us - (begin_us_ + bin_ * bin_us);
  if (part_us >= bin_us) {
    all.close_bin();
  } else if (bin_chances_ > 0) {
    all.time_us_ += part_us;
  }
  score.peak_rate_hz = all.peak_hz_;
  score.mean_rate_hz = static_cast<double>(score.inliers) * 1e6 / static_cast<double>(all.time_us_);
}

}  // namespace saccade
