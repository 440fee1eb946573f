#include "evaluation/scoring/precision_recall.h"

#include <algorithm>
#include <functional>

namespace saccade {
namespace {

double ratio(std::int64_t part, std::int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

std::vector<CurvePoint> thinned(const std::vector<CurvePoint>& curve) {
  if (curve.size() <= max_curve_points) return curve;
  std::vector<CurvePoint> points;
  for (std::size_t i = 0; i < max_curve_points; ++i) {
    points.push_back(curve[i * (curve.size() - 1) / (max_curve_points - 1)]);
  }
  return points;
}

}  // namespace

void PrecisionRecallCounter::add(double score, bool inlier) {
  if (!exact()) {
    add_to_bin(score, inlier);
    return;
  }
  observations_.emplace_back(score, inlier);
  if (observations_.size() <= max_exact_) return;
  for (const auto& [s, right] : observations_) add_to_bin(s, right);
  observations_ = {};
}

void PrecisionRecallCounter::add_to_bin(double score, bool inlier) {
  Bin& bin = bins_.try_emplace(fine_bin(score), Bin{.lowest = score}).first->second;
  bin.lowest = std::min(bin.lowest, score);
  ++bin.observations;
  bin.inliers += inlier ? 1 : 0;
}

/// By falling score.
std::vector<CurvePoint> PrecisionRecallCounter::curve(std::int64_t chances) const {
  std::vector<CurvePoint> points;
  std::int64_t observations = 0;
  std::int64_t inliers = 0;
  const auto add_point = [&](double threshold) {
    points.push_back({.threshold = threshold,
                      .precision = ratio(inliers, observations),
                      .recall = ratio(inliers, chances)});
  };
  for (auto bin = bins_.rbegin(); bin != bins_.rend(); ++bin) {
    observations += bin->second.observations;
    inliers += bin->second.inliers;
    add_point(bin->second.lowest);
  }
  std::vector<std::pair<double, bool>> ranked = observations_;
  std::sort(ranked.begin(), ranked.end(), std::greater<>());
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    ++observations;
    inliers += ranked[i].second ? 1 : 0;
    if (i + 1 == ranked.size() || ranked[i + 1].first != ranked[i].first) add_point(ranked[i].first);
  }
  return points;
}

CurveSummary PrecisionRecallCounter::summary(std::int64_t chances) const {
  const std::vector<CurvePoint> points = curve(chances);
  CurveSummary summary;
  double recall = 0.0;
  for (const CurvePoint& point : points) {
    summary.average_precision += point.precision * (point.recall - recall);
    recall = point.recall;
  }
  for (std::size_t i = 0; i < reported_recalls.size(); ++i) {
    const auto reached = std::find_if(points.begin(), points.end(),
                                      [&](const CurvePoint& p) { return p.recall >= reported_recalls[i]; });
    if (reached != points.end()) summary.precision_at_recall[i] = reached->precision;
  }
  summary.points = thinned(points);
  return summary;
}

}  // namespace saccade
