#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "core/flow/plane_fit_flow.h"

namespace saccade {

/// Plane fitting as PlaneFitFlow documents it, with a map for a surface and a dense least squares solver: the
/// oracle of the integer fit.
class ReferenceFlow {
 public:
  explicit ReferenceFlow(const PlaneFitFlowConfig& config) : config_(config) {}

  void add(const Event& e) { newest_[{e.on, e.x, e.y}] = e.t_us; }

  struct Answer {
    std::optional<NormalFlow> flow;
    bool clear_cut = true;  ///< false where rounding alone decides whether a neighbour is an inlier
  };
  [[nodiscard]] Answer at(const Event& e) const {
    std::vector<Eigen::Vector3d> points;  // x, y, t from the event
    std::vector<double> next_ages;        // of the eight pixels around it
    const int half = static_cast<int>(config_.half_width_px);
    for (int dy = -half; dy <= half; ++dy) {
      for (int dx = -half; dx <= half; ++dx) {
        const auto found = newest_.find({e.on, e.x + dx, e.y + dy});
        if (found == newest_.end() || e.t_us - found->second > config_.max_age_us) continue;
        points.emplace_back(dx, dy, static_cast<double>(found->second - e.t_us));
        if (std::max(std::abs(dx), std::abs(dy)) == 1) next_ages.push_back(-points.back().z());
      }
    }
    Answer answer;
    if (next_ages.size() >= 4) {
      std::sort(next_ages.begin(), next_ages.end());
      std::erase_if(points, [&](const Eigen::Vector3d& p) { return -p.z() > 4 * next_ages[3]; });
    }
    std::vector<Eigen::Vector3d> inliers = points;
    for (const bool again : {false, true}) {
      if (static_cast<std::int64_t>(inliers.size()) < config_.min_inliers) return answer;
      Eigen::MatrixX3d m(inliers.size(), 3);
      Eigen::VectorXd t(inliers.size());
      for (Eigen::Index i = 0; i < m.rows(); ++i) {
        const Eigen::Vector3d& p = inliers[static_cast<std::size_t>(i)];
        m.row(i) << p.x(), p.y(), 1.0;
        t[i] = p.z();
      }
      const auto qr = m.colPivHouseholderQr();
      if (qr.rank() < 3) return answer;
      const Eigen::Vector3d plane = qr.solve(t);
      const double slope = std::hypot(plane[0], plane[1]);
      if (again) {
        if (slope > 1e-9) answer.flow = NormalFlow{plane[0], plane[1]};  // else level
        return answer;
      }
      inliers.clear();
      for (const Eigen::Vector3d& p : points) {
        const double off = std::abs(plane[0] * p.x() + plane[1] * p.y() + plane[2] - p.z());
        const double margin = off - config_.inlier_px * slope;
        if (std::abs(margin) < 1e-6 * slope + 1e-6) answer.clear_cut = false;
        if (margin <= 0.0) inliers.push_back(p);
      }
    }
    return answer;
  }

 private:
  PlaneFitFlowConfig config_;
  std::map<std::tuple<bool, int, int>, std::int64_t> newest_;
};

}  // namespace saccade
