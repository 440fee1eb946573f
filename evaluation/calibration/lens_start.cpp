#include "evaluation/calibration/lens_start.h"

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/rotation_vector.h"
#include "core/units.h"

namespace saccade {
namespace {

Eigen::Isometry3d pose_of(const cv::Mat& turn, const cv::Mat& at) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int k = 0; k < 3; ++k) pose.translation()[k] = at.at<double>(k);
  pose.linear() =
      rotation_of({turn.at<double>(0), turn.at<double>(1), turn.at<double>(2)}).toRotationMatrix();
  return pose;
}

BoardModel start_of_pinhole(const std::vector<CalibrationView>& views, const DotGrid& grid, ImageSize size) {
  std::vector<cv::Point3f> points;
  for (const cv::Point3d& p : grid.points_m()) points.emplace_back(p);
  const std::vector<std::vector<cv::Point3f>> objects(views.size(), points);
  std::vector<std::vector<cv::Point2f>> images;
  for (const CalibrationView& view : views) {
    images.emplace_back(view.grid.dots_px.begin(), view.grid.dots_px.end());
  }
  cv::Mat matrix, distortion;
  std::vector<cv::Mat> rotations, translations;
  cv::calibrateCamera(objects, images, cv::Size(size.width, size.height), matrix, distortion, rotations,
                      translations, cv::CALIB_FIX_K3);
  BoardModel model;
  model.camera = {size,
                  matrix.at<double>(0, 0),
                  matrix.at<double>(1, 1),
                  matrix.at<double>(0, 2),
                  matrix.at<double>(1, 2),
                  distortion.at<double>(0),
                  distortion.at<double>(1),
                  distortion.at<double>(2),
                  distortion.at<double>(3)};
  for (std::size_t i = 0; i < views.size(); ++i) {
    model.boards.push_back(pose_of(rotations[i], translations[i]));
  }
  return model;
}

/// The boards before a camera that is known; none where one is not found.
std::optional<std::vector<Eigen::Isometry3d>> boards_before(const Camera& camera,
                                                            const std::vector<CalibrationView>& views,
                                                            const std::vector<cv::Point3d>& points_m) {
  std::vector<Eigen::Isometry3d> boards;
  for (const CalibrationView& view : views) {
    std::vector<cv::Point2d> rays;
    for (const cv::Point2d& dot : view.grid.dots_px) {
      const Eigen::Vector3d ray = camera.ray(dot.x, dot.y);
      if (!ray.allFinite()) return std::nullopt;
      rays.emplace_back(ray.x(), ray.y());
    }
    cv::Mat turn, at;
    if (!cv::solvePnP(points_m, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turn, at))
      return std::nullopt;
    boards.push_back(pose_of(turn, at));
  }
  return boards;
}

BoardModel start_of_fisheye(const std::vector<CalibrationView>& views, const DotGrid& grid, ImageSize size) {
  std::vector<BoardView> seen;
  for (std::size_t i = 0; i < views.size(); ++i) seen.push_back({views[i].grid.dots_px, i, std::nullopt});
  const BoardFit fit(grid, std::move(seen), FreeParameters::lens_and_boards);
  const double half_diagonal_px = 0.5 * std::hypot(size.width, size.height);
  BoardModel best;
  double best_rms_px = std::numeric_limits<double>::infinity();
  for (double corner_deg = 15.0; corner_deg <= 85.0; corner_deg += 5.0) {
    const double focal_px = half_diagonal_px / (corner_deg * rad_per_deg);
    const Camera camera{.size = size,
                        .fx_px = focal_px,
                        .fy_px = focal_px,
                        .cx_px = 0.5 * (size.width - 1),
                        .cy_px = 0.5 * (size.height - 1),
                        .lens = LensModel::fisheye};
    auto boards = boards_before(camera, views, grid.points_m());
    if (!boards) continue;
    BoardModel model{camera, Eigen::Isometry3d::Identity(), std::move(*boards)};
    const double rms_px = fit.rms_px(model);
    if (!(rms_px < best_rms_px)) continue;
    best_rms_px = rms_px;
    best = std::move(model);
  }
  if (best.boards.empty()) throw RunError("no calibration: the dots fit no equidistant lens");
  return best;
}

}  // namespace

BoardModel start_of_lens(const std::vector<CalibrationView>& views, const DotGrid& grid, ImageSize size,
                         LensModel lens) {
  return lens == LensModel::fisheye ? start_of_fisheye(views, grid, size)
                                    : start_of_pinhole(views, grid, size);
}

}  // namespace saccade
