#include "evaluation/scoring/uncertainty.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace saccade {

std::optional<double> ReliabilityBin::inlier_share() const {
  if (observations == 0) return std::nullopt;
  return static_cast<double>(inliers) / static_cast<double>(observations);
}

void ReliabilityCounter::add(double score, bool inlier) {
  any_ = true;
  if (score < 0.0 || score > 1.0) {
    outside_ = true;
    return;
  }
  const auto bin = static_cast<std::size_t>(score * static_cast<double>(reliability_bins));
  ReliabilityBin& counted = bins_[std::min(bin, reliability_bins - 1)];
  ++counted.observations;
  counted.inliers += inlier ? 1 : 0;
  counted.mean_score += (score - counted.mean_score) / static_cast<double>(counted.observations);
}

std::optional<Reliability> ReliabilityCounter::result() const {
  if (!any_ || outside_) return std::nullopt;
  return bins_;
}

std::optional<double> nees_of(const Circle& circle, const Eigen::Matrix3d& covariance_px2,
                              const Circle& truth) {
  if (!covariance_px2.allFinite() || covariance_px2.isZero(0.0)) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix3d> decomposition(covariance_px2);
  if (decomposition.info() != Eigen::Success) return std::nullopt;
  const Eigen::Vector3d error_px(circle.x_px - truth.x_px, circle.y_px - truth.y_px,
                                 circle.r_px - truth.r_px);
  const double nees = error_px.dot(decomposition.solve(error_px));
  return std::isfinite(nees) ? std::optional(nees) : std::nullopt;
}

void NeesCounter::add(const std::optional<double>& nees) {
  if (!nees) return;
  values_.add(*nees);
  below_ += *nees < nees_bound ? 1 : 0;
}

std::optional<Nees> NeesCounter::result() const {
  const std::optional<double> median = values_.at(0.5);
  if (!median) return std::nullopt;
  return Nees{values_.count(), static_cast<double>(below_) / static_cast<double>(values_.count()), *median};
}

}  // namespace saccade
