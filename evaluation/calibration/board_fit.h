#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "evaluation/calibration/grid_finder.h"

namespace saccade {

/// Least squares over the dots of a board in many views, solved with Ceres.

/// The parameters of the fit: lens, mount, and the poses of the boards.
struct BoardModel {
  Camera camera;
  Eigen::Isometry3d eye_from_camera = Eigen::Isometry3d::Identity();
  /// Of each board in its frame of reference: the camera (one board per view) or root (one per rest).
  std::vector<Eigen::Isometry3d> boards;
};

/// The dots of one view and the board that they are on.
struct BoardView {
  std::span<const cv::Point2d> dots_px;
  std::size_t board = 0;                           ///< index into BoardModel::boards
  std::optional<Eigen::Isometry3d> root_from_eye;  ///< where boards are in root
};

/// Which parameters are free; the others keep their values.
enum class FreeParameters { lens_and_boards, mount_and_boards, all };

/// The parameters of a lens in the order of a fit: fx, fy, cx, cy, k1, k2, then p1, p2 or a fisheye's k3, k4.
inline constexpr int lens_size = 8;
[[nodiscard]] const std::array<double Camera::*, lens_size>& lens_members(LensModel lens);

/// The distances between seen dots and the centroids of the projected discs, of all views; x and y in turn, px.
class BoardFit {
 public:
  /// Every view has all dots of `grid`; the spans outlive the fit. The last `held` parameters of the lens, at most 7, keep
  /// their values.
  BoardFit(const DotGrid& grid, std::vector<BoardView> views, FreeParameters free, int held = 0);

  /// Levenberg-Marquardt from `start`. Throws RunError where the dots do not determine the parameters.
  [[nodiscard]] BoardModel solve(const BoardModel& start) const;

  /// Standard deviations of lens (in the order of lens_members()) and mount (translation m, rotation rad), of those that
  /// are free, 0 for what is held: the covariance of the residuals taken as common to the dots of a view (sandwich), and never less than what
  /// independent dots would give. Throws RunError as solve().
  [[nodiscard]] Eigen::VectorXd deviations(const BoardModel& model) const;

  [[nodiscard]] double rms_px(const BoardModel& model) const;
  [[nodiscard]] double rms_px(const BoardModel& model, std::size_t view) const;
  [[nodiscard]] std::size_t view_count() const { return views_.size(); }

 private:
  [[nodiscard]] double squared_px2(const BoardModel& model, std::size_t view) const;

  std::vector<cv::Point3d> points_m_;
  double radius_m_;
  std::vector<BoardView> views_;
  FreeParameters free_;
  int held_;
};

}  // namespace saccade
