#include "evaluation/calibration/calibration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "core/error.h"

namespace saccade {
namespace {

constexpr double deg_per_rad = 180.0 / std::numbers::pi;
constexpr int lens_size = 8;
constexpr int pose_size = 6;
constexpr int raster = 5;

using Lens = Eigen::Matrix<double, lens_size, 1>;
constexpr std::array<double Camera::*, lens_size> lens_members = {
    &Camera::fx_px, &Camera::fy_px, &Camera::cx_px, &Camera::cy_px,
    &Camera::k1,    &Camera::k2,    &Camera::p1,    &Camera::p2};

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& vector_rad) {
  const double angle = vector_rad.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector_rad / angle).toRotationMatrix();
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

/// A small change of a pose: its origin in the outer frame, its axes in the inner one.
Eigen::Isometry3d changed(const Eigen::Isometry3d& pose, const Eigen::Matrix<double, pose_size, 1>& by) {
  Eigen::Isometry3d result = pose;
  result.translation() += by.head<3>();
  result.linear() = pose.linear() * rotation_of(by.tail<3>());
  return result;
}

/// Everything that is estimated: lens, mount, and the poses of the boards.
struct Model {
  Camera camera;
  Eigen::Isometry3d eye_from_camera = Eigen::Isometry3d::Identity();
  /// Of each board in its frame of reference: the camera (one board per view) or root (one per rest).
  std::vector<Eigen::Isometry3d> boards;
};

/// A view as the least squares see it.
struct Observation {
  const GridView* grid = nullptr;
  std::size_t board = 0;
  std::optional<Eigen::Isometry3d> root_from_eye;  ///< where boards are in root
};

/// Which parameters are free.
enum class Free { lens_and_boards, mount_and_boards, all };

/// The centroid of a disc's image.
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

class LeastSquares {
 public:
  LeastSquares(const DotGrid& grid, std::vector<Observation> observations, Free free)
      : points_m_(grid.points_m()),
        radius_m_(0.5 * grid.dot_diameter_m),
        observations_(std::move(observations)),
        lens_(free == Free::mount_and_boards ? 0 : lens_size),
        shared_(lens_ + (free == Free::lens_and_boards ? 0 : pose_size)) {}

  /// Levenberg-Marquardt from `model`.
  [[nodiscard]] Model solve(Model model) const {
    double lambda = 1e-3;
    double cost = cost_of(model);
    for (int round = 0; round < 60; ++round) {
      const Normal normal = linearise(model);
      bool better = false;
      for (int attempt = 0; attempt < 10 && !better; ++attempt) {
        Eigen::MatrixXd damped = normal.matrix;
        damped.diagonal() *= 1.0 + lambda;
        const Model next = stepped(model, damped.ldlt().solve(-normal.gradient));
        const double next_cost = cost_of(next);
        better = next_cost < cost;
        if (better) {
          const bool done = cost - next_cost < 1e-8 * cost;
          model = next;
          cost = next_cost;
          lambda = std::max(lambda * 0.2, 1e-9);
          if (done) return model;
        } else {
          lambda *= 8.0;
        }
      }
      if (!better) break;
    }
    return model;
  }

  /// Standard deviations of the shared parameters: lens, or translation (m) and rotation (rad) of the mount.
  [[nodiscard]] Eigen::VectorXd deviations(const Model& model) const {
    const Normal normal = linearise(model);
    const Eigen::Index size = normal.matrix.rows();
    // Columns of the inverse that belong to the shared parameters.
    const Eigen::MatrixXd inverse = normal.matrix.ldlt().solve(Eigen::MatrixXd::Identity(size, shared_));
    Eigen::VectorXd clustered = Eigen::VectorXd::Zero(shared_);
    for (const Eigen::VectorXd& gradient : normal.gradients) {
      clustered += (inverse.transpose() * gradient).cwiseAbs2();
    }
    const auto views = static_cast<double>(observations_.size());
    clustered *= views / (views - 1.0);
    // Where every view has a pose of its own that pose takes up what its dots have in common: never less than what
    // independent dots would leave.
    const double dots = 2.0 * views * static_cast<double>(points_m_.size());
    const double variance = cost_of(model) / (dots - static_cast<double>(size));
    return clustered.cwiseMax(variance * inverse.topRows(shared_).diagonal()).cwiseSqrt();
  }

  [[nodiscard]] double rms_px(const Model& model) const {
    return std::sqrt(cost_of(model) / static_cast<double>(observations_.size() * points_m_.size()));
  }
  [[nodiscard]] double rms_px(const Model& model, std::size_t view) const {
    return std::sqrt(
        residuals(part_of(model, observations_[view]), observations_[view], radius_m_).squaredNorm() /
        static_cast<double>(points_m_.size()));
  }
  [[nodiscard]] const std::vector<Observation>& observations() const { return observations_; }

 private:
  struct Normal {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd gradient;
    std::vector<Eigen::VectorXd> gradients;  ///< of each view
  };

  /// The part of a model that one view depends on.
  struct Part {
    Camera camera;
    Eigen::Isometry3d eye_from_camera;
    Eigen::Isometry3d board;
  };
  static Part part_of(const Model& model, const Observation& o) {
    return {model.camera, model.eye_from_camera, model.boards[o.board]};
  }

  [[nodiscard]] Eigen::VectorXd residuals(const Part& part, const Observation& o, double radius_m) const {
    const Eigen::Isometry3d pose =
        o.root_from_eye ? (*o.root_from_eye * part.eye_from_camera).inverse() * part.board : part.board;
    Eigen::VectorXd r(2 * static_cast<Eigen::Index>(points_m_.size()));
    for (std::size_t i = 0; i < points_m_.size(); ++i) {
      const auto seen = disc_centroid(part.camera, pose, points_m_[i], radius_m);
      const auto row = 2 * static_cast<Eigen::Index>(i);
      constexpr double far_px = 1e3;
      r[row] = seen ? seen->x() - o.grid->dots_px[i].x : far_px;
      r[row + 1] = seen ? seen->y() - o.grid->dots_px[i].y : far_px;
    }
    return r;
  }

  [[nodiscard]] double cost_of(const Model& model) const {
    double cost = 0.0;
    for (const Observation& o : observations_)
      cost += residuals(part_of(model, o), o, radius_m_).squaredNorm();
    return cost;
  }

  /// The part with a step in one of the shared parameters or, after them, of the board's.
  [[nodiscard]] Part with_step(Part part, int parameter, double step) const {
    Eigen::Matrix<double, pose_size, 1> by = Eigen::Matrix<double, pose_size, 1>::Zero();
    if (parameter < lens_) {
      part.camera.*lens_members[static_cast<std::size_t>(parameter)] += step;
    } else if (parameter < shared_) {
      by[parameter - lens_] = step;
      part.eye_from_camera = changed(part.eye_from_camera, by);
    } else {
      by[parameter - shared_] = step;
      part.board = changed(part.board, by);
    }
    return part;
  }
  [[nodiscard]] Model stepped(const Model& model, const Eigen::VectorXd& by) const {
    Model next = model;
    for (int i = 0; i < lens_; ++i) next.camera.*lens_members[static_cast<std::size_t>(i)] += by[i];
    if (shared_ > lens_) {
      next.eye_from_camera = changed(model.eye_from_camera, by.segment<pose_size>(lens_));
    }
    for (std::size_t i = 0; i < model.boards.size(); ++i) {
      next.boards[i] = changed(model.boards[i], by.segment<pose_size>(first_of(i)));
    }
    return next;
  }
  [[nodiscard]] Eigen::Index first_of(std::size_t board) const {
    return shared_ + pose_size * static_cast<Eigen::Index>(board);
  }

  [[nodiscard]] Normal linearise(const Model& model) const {
    const Eigen::Index size = first_of(model.boards.size());
    Normal normal{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), {}};
    for (const Observation& o : observations_) {
      const Part part = part_of(model, o);
      const Eigen::VectorXd r = residuals(part, o, radius_m_);
      Eigen::MatrixXd j(r.size(), shared_ + pose_size);
      for (int p = 0; p < shared_ + pose_size; ++p) {
        const double h = p < lens_ && p < 4 ? 1e-3 : 1e-6;
        // A disc moves as its middle does.
        j.col(p) = (residuals(with_step(part, p, h), o, 0.0) - residuals(with_step(part, p, -h), o, 0.0)) /
                   (2.0 * h);
      }
      const Eigen::MatrixXd jtj = j.transpose() * j;
      const Eigen::VectorXd jtr = j.transpose() * r;
      const Eigen::Index first = first_of(o.board);
      normal.matrix.topLeftCorner(shared_, shared_) += jtj.topLeftCorner(shared_, shared_);
      normal.matrix.block(0, first, shared_, pose_size) += jtj.topRightCorner(shared_, pose_size);
      normal.matrix.block(first, 0, pose_size, shared_) += jtj.bottomLeftCorner(pose_size, shared_);
      normal.matrix.block(first, first, pose_size, pose_size) += jtj.bottomRightCorner(pose_size, pose_size);
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
      gradient.head(shared_) = jtr.head(shared_);
      gradient.segment<pose_size>(first) = jtr.tail<pose_size>();
      normal.gradient += gradient;
      normal.gradients.push_back(std::move(gradient));
    }
    return normal;
  }

  std::vector<cv::Point3d> points_m_;
  double radius_m_;
  std::vector<Observation> observations_;
  int lens_;    ///< how many parameters of the lens are free
  int shared_;  ///< and how many with the mount
};

// --------------------------------------------------------------------------------------- views

/// What makes two views different, in units of about what makes a difference: where the grid is in the image, how
/// large it is, and how its rows and columns lie.
Eigen::Matrix<double, 6, 1> looks_of(const GridView& view) {
  cv::Point2d middle(0.0, 0.0);
  for (const cv::Point2d& dot : view.dots_px) middle += dot;
  middle /= static_cast<double>(view.dots_px.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const cv::Point2d& dot : view.dots_px) {
    const Eigen::Vector2d d(dot.x - middle.x, dot.y - middle.y);
    spread += d * d.transpose() / static_cast<double>(view.dots_px.size());
  }
  const cv::Point2d along = view.dots_px.back() - view.dots_px.front();
  Eigen::Matrix<double, 6, 1> looks;
  looks << middle.x / 10.0, middle.y / 10.0, std::sqrt(spread(0, 0)) / 5.0, std::sqrt(spread(1, 1)) / 5.0,
      along.x / 15.0, along.y / 15.0;
  return looks;
}

double covered_share(const std::vector<CalibrationView>& views, ImageSize size) {
  std::array<bool, raster * raster> covered{};
  for (const CalibrationView& view : views) {
    for (const cv::Point2d& dot : view.grid.dots_px) {
      const int column = std::clamp(static_cast<int>((dot.x + 0.5) * raster / size.width), 0, raster - 1);
      const int row = std::clamp(static_cast<int>((dot.y + 0.5) * raster / size.height), 0, raster - 1);
      covered[static_cast<std::size_t>(row * raster + column)] = true;
    }
  }
  return static_cast<double>(std::count(covered.begin(), covered.end(), true)) / (raster * raster);
}

double tilt_spread_deg(const std::vector<Eigen::Isometry3d>& boards) {
  double smallest = 1.0;
  for (const Eigen::Isometry3d& a : boards) {
    for (const Eigen::Isometry3d& b : boards)
      smallest = std::min(smallest, a.linear().col(2).dot(b.linear().col(2)));
  }
  return std::acos(std::clamp(smallest, -1.0, 1.0)) * deg_per_rad;
}

void refuse_unless(bool good, const std::string& found, const std::string& wanted) {
  if (!good) throw RunError("no calibration: " + found + "; wanted: " + wanted);
}

Model started_by_opencv(const std::vector<CalibrationView>& views, const DotGrid& grid, ImageSize size) {
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
  Model model;
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
    Eigen::Isometry3d board = Eigen::Isometry3d::Identity();
    for (int k = 0; k < 3; ++k) board.translation()[k] = translations[i].at<double>(k);
    board.linear() =
        rotation_of({rotations[i].at<double>(0), rotations[i].at<double>(1), rotations[i].at<double>(2)});
    model.boards.push_back(board);
  }
  return model;
}

/// Which views fit: no more than three times worse than the one in the middle.
std::vector<bool> fitting(const LeastSquares& problem, const Model& model) {
  std::vector<double> rms_px;
  for (std::size_t i = 0; i < problem.observations().size(); ++i) rms_px.push_back(problem.rms_px(model, i));
  std::vector<double> sorted = rms_px;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  std::vector<bool> fits;
  for (const double rms : rms_px) fits.push_back(rms <= 3.0 * *middle);
  return fits;
}

template <class T>
void keep(std::vector<T>& all, const std::vector<bool>& kept) {
  std::size_t end = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (kept[i]) all[end++] = all[i];
  }
  all.resize(end);
}

bool all_of(const std::vector<bool>& values) {
  return std::find(values.begin(), values.end(), false) == values.end();
}

void note_lens(const Eigen::VectorXd& deviations, CalibrationDeviations& to) {
  for (auto [value, i] : {std::pair{&to.fx_px, 0},
                          {&to.fy_px, 1},
                          {&to.cx_px, 2},
                          {&to.cy_px, 3},
                          {&to.k1, 4},
                          {&to.k2, 5},
                          {&to.p1, 6},
                          {&to.p2, 7}}) {
    *value = deviations[i];
  }
}

/// The lens, over the views that fit it; the others are left out of `views`.
Model fit_lens(std::vector<CalibrationView>& views, const DotGrid& grid, ImageSize size,
               Calibration& result) {
  Model model = started_by_opencv(views, grid, size);
  while (true) {
    std::vector<Observation> observations;
    for (std::size_t i = 0; i < views.size(); ++i) observations.push_back({&views[i].grid, i, std::nullopt});
    const LeastSquares problem(grid, std::move(observations), Free::lens_and_boards);
    model = problem.solve(model);
    if (const std::vector<bool> fits = fitting(problem, model); !all_of(fits)) {
      keep(views, fits);
      keep(model.boards, fits);
      continue;
    }
    result.quality.rms_px = problem.rms_px(model);
    note_lens(problem.deviations(model), result.deviations);
    return model;
  }
}

/// Runs of views in which the board stays where it is in the root frame, as far as that is known without the mount.
std::vector<std::vector<std::size_t>> rests_of(const std::vector<CalibrationView>& views,
                                               const Model& model) {
  constexpr double same_place_m = 0.03;
  constexpr double same_turn_rad = 10.0 / deg_per_rad;
  std::vector<std::vector<std::size_t>> rests;
  Eigen::Isometry3d first;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Isometry3d board = *views[i].root_from_eye * model.boards[i];
    const bool same = !rests.empty() && (board.translation() - first.translation()).norm() < same_place_m &&
                      rotation_vector(first.linear().transpose() * board.linear()).norm() < same_turn_rad;
    if (!same) {
      rests.emplace_back();
      first = board;
    }
    rests.back().push_back(i);
  }
  return rests;
}

void fit_mount(const std::vector<CalibrationView>& views, const DotGrid& grid,
               const CalibrationLimits& limits, const Model& lens, Calibration& result) {
  Model model;
  std::vector<Observation> observations;
  std::vector<bool> fits(views.size(), true);
  // Views in which the board moves between rests are found by that they do not fit.
  while (true) {
    model = Model{lens.camera, model.eye_from_camera, {}};
    observations.clear();
    std::vector<std::size_t> view_of;
    for (const std::vector<std::size_t>& rest : rests_of(views, lens)) {
      std::vector<std::size_t> good;
      std::copy_if(rest.begin(), rest.end(), std::back_inserter(good),
                   [&](std::size_t i) { return fits[i]; });
      if (good.size() < limits.min_views_of_rest) continue;
      for (const std::size_t i : good) {
        observations.push_back({&views[i].grid, model.boards.size(), views[i].root_from_eye});
        view_of.push_back(i);
      }
      const std::size_t middle = good[good.size() / 2];
      model.boards.push_back(*views[middle].root_from_eye * model.eye_from_camera * lens.boards[middle]);
    }
    result.quality.rests = static_cast<std::int64_t>(model.boards.size());
    refuse_unless(
        model.boards.size() >= limits.min_rests,
        fmt::format("the board rested at {} poses long enough for {} views while the eye moved",
                    model.boards.size(), limits.min_views_of_rest),
        fmt::format("{} such poses, for the eye's pose (without it: --no_joints)", limits.min_rests));
    const LeastSquares problem(grid, observations, Free::mount_and_boards);
    model = problem.solve(model);
    const std::vector<bool> now_fit = fitting(problem, model);
    if (all_of(now_fit)) break;
    for (std::size_t i = 0; i < now_fit.size(); ++i) fits[view_of[i]] = now_fit[i];
  }
  // How the image turns with the eye says more of the lens than poses that are anything: where joints and pictures
  // agree, both are taken together.
  constexpr double agree = 1.5;
  const LeastSquares together(grid, observations, Free::all);
  const Model all = together.solve(model);
  Eigen::VectorXd d;
  if (together.rms_px(all) <= agree * result.quality.rms_px) {
    model = all;
    result.camera.camera = model.camera;
    result.quality.rms_at_rest_px = together.rms_px(model);
    d = together.deviations(model);
    note_lens(d, result.deviations);
    d = d.tail<pose_size>().eval();
  } else {
    const LeastSquares alone(grid, observations, Free::mount_and_boards);
    result.quality.rms_at_rest_px = alone.rms_px(model);
    d = alone.deviations(model);
  }
  const Eigen::Vector3d turn_deg = rotation_vector(model.eye_from_camera.linear()) * deg_per_rad;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    result.camera.mount.translation_mm[k] = model.eye_from_camera.translation()[i] * 1e3;
    result.camera.mount.rotation_deg[k] = turn_deg[i];
    result.deviations.translation_mm[k] = d[i] * 1e3;
    result.deviations.rotation_deg[k] = d[3 + i] * deg_per_rad;
  }
}

}  // namespace

void describe(FieldVisitor& v, Calibration& c) {
  constexpr Range deviation{0.0, 1e6};
  v.section(
      "calibration", [&](FieldVisitor& w) { describe(w, c.camera); }, "what is believed of the camera");
  v.section(
      "deviations",
      [&](FieldVisitor& w) {
        CalibrationDeviations& d = c.deviations;
        for (auto [key, value] : {std::pair{"fx_px", &d.fx_px},
                                  {"fy_px", &d.fy_px},
                                  {"cx_px", &d.cx_px},
                                  {"cy_px", &d.cy_px},
                                  {"k1", &d.k1},
                                  {"k2", &d.k2},
                                  {"p1", &d.p1},
                                  {"p2", &d.p2}}) {
          w.real(key, *value, deviation, "standard deviation");
        }
        w.reals("translation_mm", d.translation_mm, 3, deviation, "standard deviations of eye_from_camera");
        w.reals("rotation_deg", d.rotation_deg, 3, deviation, "standard deviations of eye_from_camera");
      },
      "standard deviations of it; 0 for what is not known");
  v.section(
      "quality",
      [&](FieldVisitor& w) {
        w.integer("views", c.quality.views, {0, 1e9}, "that it is made of");
        w.real("rms_px", c.quality.rms_px, deviation, "distance of the dots, each view with its own pose");
        w.real("covered", c.quality.covered, {0.0, 1.0}, "share of a raster over the image with dots");
        w.real("tilt_spread_deg", c.quality.tilt_spread_deg, {0.0, 180.0}, "between the board's tilts");
        w.integer("rests", c.quality.rests, {0, 1e9},
                  "poses of the resting board; 0: eye_from_camera is not known");
        w.real("rms_at_rest_px", c.quality.rms_at_rest_px, deviation,
               "distance of the dots, by the head's joints");
      },
      "how well it fits");
}

std::vector<CalibrationView> choose_views(const std::vector<CalibrationView>& views,
                                          const CalibrationLimits& limits) {
  std::vector<const CalibrationView*> slow;
  for (const CalibrationView& view : views) {
    if (view.grid.speed_px_s <= limits.max_speed_px_s) slow.push_back(&view);
  }
  // One after the other the view that is least like those chosen.
  std::vector<double> apart(slow.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> chosen;
  while (chosen.size() < std::min(limits.max_views, slow.size())) {
    const auto next = static_cast<std::size_t>(std::max_element(apart.begin(), apart.end()) - apart.begin());
    chosen.push_back(next);
    for (std::size_t i = 0; i < slow.size(); ++i) {
      apart[i] = std::min(apart[i], (looks_of(slow[i]->grid) - looks_of(slow[next]->grid)).norm());
    }
    apart[next] = -1.0;
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<CalibrationView> result;
  for (const std::size_t i : chosen) result.push_back(*slow[i]);
  return result;
}

Calibration calibrate(const std::vector<CalibrationView>& all, const DotGrid& grid, ImageSize size,
                      bool with_mount, const CalibrationLimits& limits) {
  std::vector<CalibrationView> views = choose_views(all, limits);
  const std::string found =
      fmt::format("the whole grid was found in {} pictures, in {} of them at less than {} px/s", all.size(),
                  views.size(), limits.max_speed_px_s);
  refuse_unless(
      views.size() >= limits.min_views, found,
      fmt::format("{} views; is it a grid of {} x {}, wholly in the image, and does it make events?",
                  limits.min_views, grid.columns, grid.rows));
  Calibration result;
  result.quality.covered = covered_share(views, size);
  refuse_unless(result.quality.covered >= limits.min_covered,
                fmt::format("dots in {:.0f} % of a {} x {} raster over the image",
                            100.0 * result.quality.covered, raster, raster),
                fmt::format("{:.0f} %: views nearer to the image's borders", 100.0 * limits.min_covered));
  const Model lens = fit_lens(views, grid, size, result);
  result.camera.camera = lens.camera;
  result.quality.views = static_cast<std::int64_t>(views.size());
  result.quality.tilt_spread_deg = tilt_spread_deg(lens.boards);
  refuse_unless(views.size() >= limits.min_views, fmt::format("{} views that fit together", views.size()),
                fmt::format("{}", limits.min_views));
  refuse_unless(result.quality.rms_px <= limits.max_rms_px,
                fmt::format("dots {:.2f} px from where they should be (rms)", result.quality.rms_px),
                fmt::format("{} px; are spacing and dots as given?", limits.max_rms_px));
  refuse_unless(result.quality.tilt_spread_deg >= limits.min_tilt_spread_deg,
                fmt::format("tilts of the board that differ by {:.0f} deg", result.quality.tilt_spread_deg),
                fmt::format("{:.0f} deg", limits.min_tilt_spread_deg));
  const CalibrationDeviations& d = result.deviations;
  refuse_unless(d.fx_px <= limits.max_focal_deviation * lens.camera.fx_px &&
                    d.fy_px <= limits.max_focal_deviation * lens.camera.fy_px &&
                    std::max(d.cx_px, d.cy_px) <= limits.max_centre_deviation_px,
                fmt::format("fx +- {:.2f}, fy +- {:.2f}, cx +- {:.2f}, cy +- {:.2f} px", d.fx_px, d.fy_px,
                            d.cx_px, d.cy_px),
                fmt::format("{:.0f} % and {} px: more views, of more tilts and places",
                            100.0 * limits.max_focal_deviation, limits.max_centre_deviation_px));
  if (!with_mount) return result;
  fit_mount(views, grid, limits, lens, result);
  const double worst_mm = *std::max_element(d.translation_mm.begin(), d.translation_mm.end());
  const double worst_deg = *std::max_element(d.rotation_deg.begin(), d.rotation_deg.end());
  refuse_unless(
      worst_mm <= limits.max_translation_deviation_mm && worst_deg <= limits.max_rotation_deviation_deg,
      fmt::format("the camera's pose in the eye to +- {:.2f} mm and +- {:.2f} deg", worst_mm, worst_deg),
      fmt::format("{} mm and {} deg: more rests, and more turns of neck and eyes at each",
                  limits.max_translation_deviation_mm, limits.max_rotation_deviation_deg));
  return result;
}

}  // namespace saccade
