#include "evaluation/calibration/calibration_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "evaluation/calibration/calibration.h"

namespace saccade {
namespace {

/// Place, size and orientation of the grid in the image, each divided by a difference that matters.
Eigen::Matrix<double, 6, 1> appearance_of(const GridView& view) {
  cv::Point2d middle(0.0, 0.0);
  for (const cv::Point2d& dot : view.dots_px) middle += dot;
  middle /= static_cast<double>(view.dots_px.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const cv::Point2d& dot : view.dots_px) {
    const Eigen::Vector2d d(dot.x - middle.x, dot.y - middle.y);
    spread += d * d.transpose() / static_cast<double>(view.dots_px.size());
  }
  const cv::Point2d along = view.dots_px.back() - view.dots_px.front();
  Eigen::Matrix<double, 6, 1> appearance;
  appearance << middle.x / 10.0, middle.y / 10.0, std::sqrt(spread(0, 0)) / 5.0,
      std::sqrt(spread(1, 1)) / 5.0, along.x / 15.0, along.y / 15.0;
  return appearance;
}

}  // namespace

double covered_share(const std::vector<CalibrationView>& views, ImageSize size) {
  std::array<bool, coverage_raster * coverage_raster> covered{};
  for (const CalibrationView& view : views) {
    for (const cv::Point2d& dot : view.grid.dots_px) {
      const int column =
          std::clamp(static_cast<int>((dot.x + 0.5) * coverage_raster / size.width), 0, coverage_raster - 1);
      const int row =
          std::clamp(static_cast<int>((dot.y + 0.5) * coverage_raster / size.height), 0, coverage_raster - 1);
      covered[static_cast<std::size_t>(row * coverage_raster + column)] = true;
    }
  }
  return static_cast<double>(std::count(covered.begin(), covered.end(), true)) /
         (coverage_raster * coverage_raster);
}

double tilt_range_deg(const std::vector<Eigen::Isometry3d>& boards) {
  double smallest = 1.0;
  for (const Eigen::Isometry3d& a : boards) {
    for (const Eigen::Isometry3d& b : boards)
      smallest = std::min(smallest, a.linear().col(2).dot(b.linear().col(2)));
  }
  return std::acos(std::clamp(smallest, -1.0, 1.0)) * deg_per_rad;
}

std::vector<CalibrationView> choose_views(const std::vector<CalibrationView>& views,
                                          const CalibrationLimits& limits) {
  std::vector<const CalibrationView*> slow;
  for (const CalibrationView& view : views) {
    if (view.grid.speed_px_s <= limits.max_speed_px_s) slow.push_back(&view);
  }
  // Again and again the view that differs most from those chosen.
  std::vector<double> apart(slow.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> chosen;
  while (chosen.size() < std::min(limits.max_views, slow.size())) {
    const auto next = static_cast<std::size_t>(std::max_element(apart.begin(), apart.end()) - apart.begin());
    chosen.push_back(next);
    for (std::size_t i = 0; i < slow.size(); ++i) {
      apart[i] = std::min(apart[i], (appearance_of(slow[i]->grid) - appearance_of(slow[next]->grid)).norm());
    }
    apart[next] = -1.0;
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<CalibrationView> result;
  for (const std::size_t i : chosen) result.push_back(*slow[i]);
  return result;
}

}  // namespace saccade
