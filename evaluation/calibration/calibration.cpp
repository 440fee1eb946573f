#include "evaluation/calibration/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/rotation_vector.h"
#include "core/units.h"
#include "evaluation/calibration/board_fit.h"
#include "evaluation/calibration/lens_start.h"

namespace saccade {
namespace {

void refuse_unless(bool good, const std::string& found, const std::string& wanted) {
  if (!good) throw RunError("no calibration: " + found + "; wanted: " + wanted);
}

/// For each view whether it fits: whether its rms is at most three times the median.
std::vector<bool> fitting(const BoardFit& problem, const BoardModel& model) {
  std::vector<double> rms_px;
  for (std::size_t i = 0; i < problem.view_count(); ++i) rms_px.push_back(problem.rms_px(model, i));
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

/// A parameter of a lens.
struct LensKey {
  const char* key;
  double Camera::*value;
  double CalibrationDeviations::*deviation;
};

constexpr auto lens_keys = std::to_array<LensKey>({{"fx_px", &Camera::fx_px, &CalibrationDeviations::fx_px},
                                                   {"fy_px", &Camera::fy_px, &CalibrationDeviations::fy_px},
                                                   {"cx_px", &Camera::cx_px, &CalibrationDeviations::cx_px},
                                                   {"cy_px", &Camera::cy_px, &CalibrationDeviations::cy_px},
                                                   {"k1", &Camera::k1, &CalibrationDeviations::k1},
                                                   {"k2", &Camera::k2, &CalibrationDeviations::k2},
                                                   {"p1", &Camera::p1, &CalibrationDeviations::p1},
                                                   {"p2", &Camera::p2, &CalibrationDeviations::p2},
                                                   {"k3", &Camera::k3, &CalibrationDeviations::k3},
                                                   {"k4", &Camera::k4, &CalibrationDeviations::k4}});

const LensKey& lens_key(double Camera::*member) {
  return *std::find_if(lens_keys.begin(), lens_keys.end(),
                       [&](const LensKey& key) { return key.value == member; });
}

void note_lens(LensModel lens, const Eigen::VectorXd& deviations, CalibrationDeviations& to) {
  const auto& members = lens_members(lens);
  for (std::size_t i = 0; i < members.size(); ++i) {
    to.*lens_key(members[i]).deviation = deviations[static_cast<Eigen::Index>(i)];
  }
}

/// Whether a scenario accepts the camera: its lens shows the whole image.
bool is_readable(const Camera& camera) {
  try {
    check_config("calibration", camera);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

/// Fits the lens; views that do not fit are removed from `views`.
BoardModel fit_lens(std::vector<CalibrationView>& views, const DotGrid& grid, ImageSize size, LensModel lens,
                    Calibration& result) {
  const auto problem_of = [&](int held) {
    std::vector<BoardView> fitted;
    for (std::size_t i = 0; i < views.size(); ++i) fitted.push_back({views[i].grid.dots_px, i, std::nullopt});
    return BoardFit(grid, std::move(fitted), FreeParameters::lens_and_boards, held);
  };
  constexpr int distortions = 4;
  const bool fisheye = lens == LensModel::fisheye;
  BoardModel model = start_of_lens(views, grid, size, lens);
  if (fisheye) model = problem_of(distortions).solve(model);
  int held = 0;
  while (true) {
    const BoardFit problem = problem_of(held);
    model = problem.solve(model);
    if (const std::vector<bool> fits = fitting(problem, model); !all_of(fits)) {
      keep(views, fits);
      keep(model.boards, fits);
      continue;
    }
    const Eigen::VectorXd deviations = problem.deviations(model);
    if (fisheye && held < distortions) {
      constexpr double significant = 3.0;  // deviations
      const int last = lens_size - 1 - held;
      double& value = model.camera.*lens_members(lens)[static_cast<std::size_t>(last)];
      if (!(std::abs(value) >= significant * deviations[last]) || !is_readable(model.camera)) {
        value = 0.0;
        ++held;
        continue;
      }
    }
    result.quality.rms_px = problem.rms_px(model);
    result.quality.held = held;
    note_lens(lens, deviations, result.deviations);
    return model;
  }
}

/// The largest angle between a dot and the optical axis.
double max_angle_deg(const std::vector<CalibrationView>& views, const Camera& camera) {
  double largest = 0.0;
  for (const CalibrationView& view : views) {
    for (const cv::Point2d& dot : view.grid.dots_px) {
      const double angle_deg = std::atan(camera.ray(dot.x, dot.y).head<2>().norm()) * deg_per_rad;
      largest = std::max(largest, angle_deg);  // a dot without a ray, NaN, leaves it
    }
  }
  return largest;
}

/// Series of views in which the board stays where it is in the root frame, as far as that can be seen without the mount.
std::vector<std::vector<std::size_t>> rests_of(const std::vector<CalibrationView>& views,
                                               const BoardModel& model) {
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
               const CalibrationLimits& limits, const BoardModel& lens, Calibration& result) {
  BoardModel model;
  std::vector<BoardView> fitted;
  std::vector<bool> fits(views.size(), true);
  // Views in which the board moves between rests do not fit and are removed.
  while (true) {
    model = BoardModel{lens.camera, model.eye_from_camera, {}};
    fitted.clear();
    std::vector<std::size_t> view_of;
    for (const std::vector<std::size_t>& rest : rests_of(views, lens)) {
      std::vector<std::size_t> good;
      std::copy_if(rest.begin(), rest.end(), std::back_inserter(good),
                   [&](std::size_t i) { return fits[i]; });
      if (good.size() < limits.min_views_of_rest) continue;
      for (const std::size_t i : good) {
        fitted.push_back({views[i].grid.dots_px, model.boards.size(), views[i].root_from_eye});
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
        fmt::format("{} such poses, for the eye's pose (without it: --no-joints)", limits.min_rests));
    const BoardFit problem(grid, fitted, FreeParameters::mount_and_boards);
    model = problem.solve(model);
    const std::vector<bool> now_fit = fitting(problem, model);
    if (all_of(now_fit)) break;
    for (std::size_t i = 0; i < now_fit.size(); ++i) fits[view_of[i]] = now_fit[i];
  }
  // The measured motion of the eye determines the lens better than free poses do: where joints and images agree, lens and
  // mount are fitted together.
  constexpr double agree = 1.5;
  const BoardFit together(grid, fitted, FreeParameters::all, static_cast<int>(result.quality.held));
  const BoardModel all = together.solve(model);
  Eigen::VectorXd d;
  if (together.rms_px(all) <= agree * result.quality.rms_px) {
    model = all;
    result.camera.camera = model.camera;
    result.quality.rms_at_rest_px = together.rms_px(model);
    d = together.deviations(model);
    note_lens(model.camera.lens, d, result.deviations);
    d = d.tail<6>().eval();
  } else {
    const BoardFit alone(grid, fitted, FreeParameters::mount_and_boards);
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
      "calibration", [&](FieldVisitor& w) { describe(w, c.camera); }, "assumed calibration of the camera");
  v.section(
      "deviations",
      [&](FieldVisitor& w) {
        CalibrationDeviations& d = c.deviations;
        for (double Camera::*member : lens_members(c.camera.camera.lens)) {
          const LensKey& key = lens_key(member);
          w.real(key.key, d.*key.deviation, deviation, "standard deviation");
        }
        w.reals("translation_mm", d.translation_mm, deviation, "standard deviations of eye_from_camera");
        w.reals("rotation_deg", d.rotation_deg, deviation, "standard deviations of eye_from_camera");
      },
      "standard deviations; 0 for what was not calibrated or is held at 0");
  v.section(
      "quality",
      [&](FieldVisitor& w) {
        w.integer("views", c.quality.views, {0, 1e9}, "number of images that were used");
        w.real("rms_px", c.quality.rms_px, deviation,
               "rms distance of the dots, each image with a pose of its own");
        w.real("covered", c.quality.covered, {0.0, 1.0},
               "share of the cells of a raster over the image that contain dots");
        w.real("max_angle_deg", c.quality.max_angle_deg, {0.0, 90.0},
               "largest angle between a dot and the optical axis");
        w.integer(
            "held", c.quality.held, {0, 4},
            "number of the last of k1 to k4 of a fisheye that the dots do not tell from 0, and which are 0");
        w.real("tilt_spread_deg", c.quality.tilt_spread_deg, {0.0, 180.0},
               "largest angle between tilts of the board");
        w.integer("rests", c.quality.rests, {0, 1e9},
                  "number of poses of the board at rest; 0: eye_from_camera was not calibrated");
        w.real("rms_at_rest_px", c.quality.rms_at_rest_px, deviation,
               "rms distance of the dots, with poses from the joints of the head");
      },
      "how well it fits");
}

Calibration calibrate(const std::vector<CalibrationView>& all, const DotGrid& grid, ImageSize size,
                      LensModel lens_model, bool with_mount, const CalibrationLimits& limits) {
  std::vector<CalibrationView> views = choose_views(all, limits);
  const std::string found =
      fmt::format("the whole grid was found in {} images, in {} of them at less than {} px/s", all.size(),
                  views.size(), limits.max_speed_px_s);
  refuse_unless(
      views.size() >= limits.min_views, found,
      fmt::format("{} views; is it a grid of {} x {}, wholly in the image, and does it make events?",
                  limits.min_views, grid.columns, grid.rows));
  Calibration result;
  result.quality.covered = covered_share(views, size);
  refuse_unless(result.quality.covered >= limits.min_covered,
                fmt::format("dots in {:.0f} % of a {} x {} raster over the image",
                            100.0 * result.quality.covered, coverage_raster, coverage_raster),
                fmt::format("{:.0f} %: views nearer to the image's borders", 100.0 * limits.min_covered));
  const BoardModel lens = fit_lens(views, grid, size, lens_model, result);
  result.camera.camera = lens.camera;
  result.quality.views = static_cast<std::int64_t>(views.size());
  result.quality.tilt_spread_deg = tilt_range_deg(lens.boards);
  refuse_unless(views.size() >= limits.min_views, fmt::format("{} views that fit together", views.size()),
                fmt::format("{}", limits.min_views));
  refuse_unless(result.quality.rms_px <= limits.max_rms_px,
                fmt::format("dots {:.2f} px (rms) off their projections", result.quality.rms_px),
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
  const auto finish = [&] {
    refuse_unless(is_readable(result.camera.camera), "a lens that turns back inside the image",
                  "dots near the image's corners, or the other --lens");
    result.quality.max_angle_deg = max_angle_deg(views, result.camera.camera);
    return result;
  };
  if (!with_mount) return finish();
  fit_mount(views, grid, limits, lens, result);
  const double worst_mm = *std::max_element(d.translation_mm.begin(), d.translation_mm.end());
  const double worst_deg = *std::max_element(d.rotation_deg.begin(), d.rotation_deg.end());
  refuse_unless(
      worst_mm <= limits.max_translation_deviation_mm && worst_deg <= limits.max_rotation_deviation_deg,
      fmt::format("the camera's pose in the eye to +- {:.2f} mm and +- {:.2f} deg", worst_mm, worst_deg),
      fmt::format("{} mm and {} deg: more rests, and more turns of neck and eyes at each",
                  limits.max_translation_deviation_mm, limits.max_rotation_deviation_deg));
  return finish();
}

}  // namespace saccade
