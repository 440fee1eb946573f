#include "evaluation/calibration/board_fit.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/rotation_vector.h"

namespace saccade {
namespace {

constexpr int pose_size = 6;

using PoseStep = Eigen::Matrix<double, pose_size, 1>;
using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A small change of a pose: its origin in the outer frame, its axes in the inner one.
Eigen::Isometry3d changed(const Eigen::Isometry3d& pose, const PoseStep& by) {
  Eigen::Isometry3d result = pose;
  result.translation() += by.head<3>();
  result.linear() = pose.linear() * rotation_of(by.tail<3>()).toRotationMatrix();
  return result;
}

/// The centroid of a disc's image; none where the camera does not see it.
std::optional<Eigen::Vector2d> disc_centroid(const Camera& camera, const Eigen::Isometry3d& camera_from_board,
                                             const cv::Point3d& at_m, double radius_m) {
  const Eigen::Vector3d c = camera_from_board * Eigen::Vector3d(at_m.x, at_m.y, at_m.z);
  if (!(c.z() > radius_m)) return std::nullopt;
  if (radius_m == 0.0) return camera.project(c);
  const Eigen::Vector3d u = radius_m * camera_from_board.linear().col(0);
  const Eigen::Vector3d v = radius_m * camera_from_board.linear().col(1);
  // The dual conic of the disc's outline on the plane at unit depth; its ellipse is m + L (cos t, sin t).
  const Eigen::Matrix3d dual = u * u.transpose() + v * v.transpose() - c * c.transpose();
  const Eigen::Matrix3d q = dual / -dual(2, 2);
  const Eigen::Vector2d m = -q.topRightCorner<2, 1>();
  const Eigen::Matrix2d s = q.topLeftCorner<2, 2>() + m * m.transpose();
  const Eigen::Matrix2d l = s.llt().matrixL();
  const auto circle = camera.project_ellipse(m, l.col(0), l.col(1));
  if (!circle) return std::nullopt;
  return Eigen::Vector2d(circle->x_px, circle->y_px);
}

/// The parameters of one view.
struct ViewParameters {
  Camera camera;
  Eigen::Isometry3d eye_from_camera;
  Eigen::Isometry3d board;
};

ViewParameters parameters_of(const BoardModel& model, const BoardView& view) {
  return {model.camera, model.eye_from_camera, model.boards[view.board]};
}

/// Projected minus seen dots.
void write_residuals(const ViewParameters& p, const BoardView& view, const std::vector<cv::Point3d>& points_m,
                     double radius_m, double* residuals_px) {
  const Eigen::Isometry3d camera_from_board =
      view.root_from_eye ? (*view.root_from_eye * p.eye_from_camera).inverse() * p.board : p.board;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const auto seen = disc_centroid(p.camera, camera_from_board, points_m[i], radius_m);
    constexpr double far_px = 1e3;
    residuals_px[2 * i] = seen ? seen->x() - view.dots_px[i].x : far_px;
    residuals_px[2 * i + 1] = seen ? seen->y() - view.dots_px[i].y : far_px;
  }
}

bool lens_is_free(FreeParameters free) { return free != FreeParameters::mount_and_boards; }
bool mount_is_free(FreeParameters free) { return free != FreeParameters::lens_and_boards; }

/// The dots of one view as Ceres evaluates them. Parameter blocks: the lens and the step of the mount, each where it is
/// free, and the step of the board; steps are small changes from `model`.
class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(const BoardModel& model, const BoardView& view, const std::vector<cv::Point3d>& points_m,
           double radius_m, FreeParameters free)
      : model_(parameters_of(model, view)),
        view_(view),
        points_m_(points_m),
        radius_m_(radius_m),
        free_(free) {
    set_num_residuals(2 * static_cast<int>(points_m.size()));
    if (lens_is_free(free)) mutable_parameter_block_sizes()->push_back(lens_size);
    if (mount_is_free(free)) mutable_parameter_block_sizes()->push_back(pose_size);
    mutable_parameter_block_sizes()->push_back(pose_size);
  }

  bool Evaluate(const double* const* blocks, double* residuals_px, double** jacobians) const override {
    std::vector<std::vector<double>> values;
    for (std::size_t b = 0; b < parameter_block_sizes().size(); ++b) {
      values.emplace_back(blocks[b], blocks[b] + parameter_block_sizes()[b]);
    }
    write_residuals(at(values), view_, points_m_, radius_m_, residuals_px);
    if (jacobians == nullptr) return true;
    // Central differences. A disc's centroid moves as its middle does, which is faster to compute.
    std::vector<double> ahead(static_cast<std::size_t>(num_residuals()));
    std::vector<double> behind(ahead.size());
    for (std::size_t b = 0; b < values.size(); ++b) {
      if (jacobians[b] == nullptr) continue;
      const bool lens = b == 0 && lens_is_free(free_);
      for (std::size_t k = 0; k < values[b].size(); ++k) {
        const double h = lens && k < 4 ? 1e-3 : 1e-6;
        const double value = values[b][k];
        values[b][k] = value + h;
        write_residuals(at(values), view_, points_m_, 0.0, ahead.data());
        values[b][k] = value - h;
        write_residuals(at(values), view_, points_m_, 0.0, behind.data());
        values[b][k] = value;
        for (std::size_t r = 0; r < ahead.size(); ++r) {
          jacobians[b][r * values[b].size() + k] = (ahead[r] - behind[r]) / (2.0 * h);
        }
      }
    }
    return true;
  }

 private:
  [[nodiscard]] ViewParameters at(const std::vector<std::vector<double>>& blocks) const {
    ViewParameters p = model_;
    std::size_t b = 0;
    if (lens_is_free(free_)) {
      for (std::size_t i = 0; i < lens_size; ++i) p.camera.*lens_members(p.camera.lens)[i] = blocks[b][i];
      ++b;
    }
    if (mount_is_free(free_)) {
      p.eye_from_camera = changed(p.eye_from_camera, PoseStep(blocks[b].data()));
      ++b;
    }
    p.board = changed(p.board, PoseStep(blocks[b].data()));
    return p;
  }

  ViewParameters model_;
  const BoardView& view_;
  const std::vector<cv::Point3d>& points_m_;
  double radius_m_;
  FreeParameters free_;
};

/// The free parameters around a model, and the problem over them.
class Fit {
 public:
  Fit(const BoardModel& model, const std::vector<BoardView>& views, const std::vector<cv::Point3d>& points_m,
      double radius_m, FreeParameters free, int held)
      : model_(model), free_(free), held_(held), boards_(model.boards.size(), PoseStep::Zero()) {
    for (std::size_t i = 0; i < lens_size; ++i) lens_[i] = model.camera.*lens_members(model.camera.lens)[i];
    for (const BoardView& view : views) {
      auto cost = std::make_unique<ViewCost>(model, view, points_m, radius_m, free);
      costs_.push_back(cost.get());
      problem_.AddResidualBlock(cost.release(), nullptr, blocks_of(view));
    }
    if (!lens_is_free(free) || held == 0) return;
    std::vector<int> constant(static_cast<std::size_t>(held));
    std::iota(constant.begin(), constant.end(), lens_size - held);
    problem_.SetManifold(lens_.data(), new ceres::SubsetManifold(lens_size, constant));
  }

  [[nodiscard]] BoardModel solved() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-14;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable()) throw RunError("no calibration: " + summary.message);
    BoardModel result = model_;
    for (std::size_t i = 0; i < lens_size; ++i) result.camera.*lens_members(model_.camera.lens)[i] = lens_[i];
    result.eye_from_camera = changed(model_.eye_from_camera, mount_);
    for (std::size_t i = 0; i < boards_.size(); ++i) result.boards[i] = changed(model_.boards[i], boards_[i]);
    return result;
  }

  /// Rows and columns of the inverse normal matrix: those of lens and mount, and beside them those of each board.
  struct Inverse {
    Jacobian shared;
    std::vector<Jacobian> with_board;
  };
  [[nodiscard]] Inverse inverse() {
    ceres::Covariance::Options options;
    ceres::Covariance covariance(options);
    std::vector<const double*> shared = shared_blocks();
    std::vector<std::pair<const double*, const double*>> pairs;
    for (std::size_t i = 0; i < shared.size(); ++i) {
      for (std::size_t k = i; k < shared.size(); ++k) pairs.emplace_back(shared[i], shared[k]);
      for (const PoseStep& board : boards_) pairs.emplace_back(shared[i], board.data());
    }
    if (!covariance.Compute(pairs, &problem_)) {
      throw RunError("no calibration: the dots do not determine all parameters");
    }
    Inverse result;
    result.shared = block_row(covariance, shared, shared);
    for (const PoseStep& board : boards_)
      result.with_board.push_back(block_row(covariance, shared, {board.data()}));
    return result;
  }

  /// Of one view: the gradients of half its squared residuals by lens and mount, and by its board.
  [[nodiscard]] std::pair<Eigen::VectorXd, Eigen::VectorXd> gradients(std::size_t view, std::size_t board) {
    const ViewCost& cost = *costs_[view];
    std::vector<const double*> blocks = shared_blocks();
    blocks.push_back(boards_[board].data());
    Eigen::VectorXd residuals(cost.num_residuals());
    std::vector<Jacobian> jacobians;
    std::vector<double*> pointers;
    for (const int size : cost.parameter_block_sizes()) jacobians.emplace_back(cost.num_residuals(), size);
    for (Jacobian& j : jacobians) pointers.push_back(j.data());
    cost.Evaluate(blocks.data(), residuals.data(), pointers.data());
    Eigen::VectorXd by_shared(shared_size());
    Eigen::Index at = 0;
    for (std::size_t b = 0; b + 1 < jacobians.size(); ++b) {
      by_shared.segment(at, jacobians[b].cols()) = jacobians[b].transpose() * residuals;
      at += jacobians[b].cols();
    }
    return {by_shared, jacobians.back().transpose() * residuals};
  }

  [[nodiscard]] Eigen::Index shared_size() const {
    return (lens_is_free(free_) ? lens_size : 0) + (mount_is_free(free_) ? pose_size : 0);
  }
  [[nodiscard]] Eigen::Index free_size() const { return shared_size() - (lens_is_free(free_) ? held_ : 0); }

 private:
  [[nodiscard]] std::vector<double*> blocks_of(const BoardView& view) {
    std::vector<double*> blocks;
    if (lens_is_free(free_)) blocks.push_back(lens_.data());
    if (mount_is_free(free_)) blocks.push_back(mount_.data());
    blocks.push_back(boards_[view.board].data());
    return blocks;
  }
  [[nodiscard]] std::vector<const double*> shared_blocks() const {
    std::vector<const double*> blocks;
    if (lens_is_free(free_)) blocks.push_back(lens_.data());
    if (mount_is_free(free_)) blocks.push_back(mount_.data());
    return blocks;
  }
  [[nodiscard]] int size_of(const double* block) const {
    return block == lens_.data() ? lens_size : pose_size;
  }

  [[nodiscard]] Jacobian block_row(const ceres::Covariance& covariance,
                                   const std::vector<const double*>& rows,
                                   const std::vector<const double*>& columns) const {
    Eigen::Index width = 0;
    for (const double* column : columns) width += size_of(column);
    Jacobian result(shared_size(), width);
    Eigen::Index row = 0;
    for (const double* r : rows) {
      Eigen::Index column = 0;
      for (const double* c : columns) {
        Jacobian block(size_of(r), size_of(c));
        covariance.GetCovarianceBlock(r, c, block.data());
        result.block(row, column, block.rows(), block.cols()) = block;
        column += block.cols();
      }
      row += size_of(r);
    }
    return result;
  }

  BoardModel model_;
  FreeParameters free_;
  int held_;
  std::array<double, lens_size> lens_{};
  PoseStep mount_ = PoseStep::Zero();
  std::vector<PoseStep> boards_;
  std::vector<const ViewCost*> costs_;
  ceres::Problem problem_;
};

}  // namespace

const std::array<double Camera::*, lens_size>& lens_members(LensModel lens) {
  using C = Camera;
  static constexpr std::array<double C::*, lens_size> radial_tangential = {
      &C::fx_px, &C::fy_px, &C::cx_px, &C::cy_px, &C::k1, &C::k2, &C::p1, &C::p2};
  static constexpr std::array<double C::*, lens_size> fisheye = {&C::fx_px, &C::fy_px, &C::cx_px, &C::cy_px,
                                                                 &C::k1,    &C::k2,    &C::k3,    &C::k4};
  return lens == LensModel::fisheye ? fisheye : radial_tangential;
}

BoardFit::BoardFit(const DotGrid& grid, std::vector<BoardView> views, FreeParameters free, int held)
    : points_m_(grid.points_m()),
      radius_m_(0.5 * grid.dot_diameter_m),
      views_(std::move(views)),
      free_(free),
      held_(held) {
  for (const BoardView& view : views_) SACCADE_CHECK(view.dots_px.size() == points_m_.size());
}

BoardModel BoardFit::solve(const BoardModel& start) const {
  return Fit(start, views_, points_m_, radius_m_, free_, held_).solved();
}

Eigen::VectorXd BoardFit::deviations(const BoardModel& model) const {
  Fit fit(model, views_, points_m_, radius_m_, free_, held_);
  const Fit::Inverse inverse = fit.inverse();
  Eigen::VectorXd clustered = Eigen::VectorXd::Zero(fit.shared_size());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const auto [by_shared, by_board] = fit.gradients(i, views_[i].board);
    clustered += (inverse.shared * by_shared + inverse.with_board[views_[i].board] * by_board).cwiseAbs2();
  }
  const auto views = static_cast<double>(views_.size());
  clustered *= views / (views - 1.0);
  // Where every view has a pose of its own that pose takes up what its dots have in common: never less than what
  // independent dots would leave.
  const double dots = 2.0 * views * static_cast<double>(points_m_.size());
  const auto parameters = static_cast<double>(fit.free_size() + pose_size * std::ssize(model.boards));
  double cost = 0.0;
  for (std::size_t i = 0; i < views_.size(); ++i) cost += squared_px2(model, i);
  const double variance = cost / (dots - parameters);
  return clustered.cwiseMax(variance * inverse.shared.diagonal()).cwiseSqrt();
}

double BoardFit::squared_px2(const BoardModel& model, std::size_t view) const {
  Eigen::VectorXd residuals(2 * std::ssize(points_m_));
  write_residuals(parameters_of(model, views_[view]), views_[view], points_m_, radius_m_, residuals.data());
  return residuals.squaredNorm();
}

double BoardFit::rms_px(const BoardModel& model) const {
  double cost = 0.0;
  for (std::size_t i = 0; i < views_.size(); ++i) cost += squared_px2(model, i);
  return std::sqrt(cost / static_cast<double>(views_.size() * points_m_.size()));
}

double BoardFit::rms_px(const BoardModel& model, std::size_t view) const {
  return std::sqrt(squared_px2(model, view) / static_cast<double>(points_m_.size()));
}

}  // namespace saccade
