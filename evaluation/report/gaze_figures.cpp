#include "evaluation/report/gaze_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "evaluation/report/figure_parts.h"
#include "evaluation/report/palette.h"
#include "evaluation/scoring/gaze_scorer.h"
#include "head/head_model.h"

namespace saccade {

using namespace figure_parts;

namespace {

constexpr Colour wrong_colour{0x00, 0x00, 0x00};
constexpr std::string_view limit_style = "lines lw 1.2 dt 2 lc rgb '#777777'";
constexpr std::string_view joint_limit_style = "lines lw 1.6 dt 2 lc rgb '#222222'";

/// The row of a table at exactly this time; null where there is none.
template <class Row>
const Row* row_at(std::span<const Row> rows, std::int64_t t_us) {
  const auto at = std::lower_bound(rows.begin(), rows.end(), t_us,
                                   [](const Row& row, std::int64_t t) { return row.t_us < t; });
  return at != rows.end() && at->t_us == t_us ? &*at : nullptr;
}

Eigen::Vector3d axis_of(const EyeRow& eye) { return eye.root_from_left_cam().linear().col(2); }

std::vector<Point> fixation_error(const GazeTables& tables, std::int64_t start_us) {
  return over_time(tables.eye, start_us, [&](const EyeRow& eye) {
    const TruthRow* truth = row_at(tables.truth, eye.t_us);
    return truth != nullptr ? angle_deg(axis_of(eye), truth->position_m - eye.position_m) : nan;
  });
}

bool is_wrong(const Move& move, const GazeTables& tables, const std::optional<Camera>& camera) {
  const TruthRow* truth = row_at(tables.truth, move.t_us);
  const EyeRow* eye = row_at(tables.eye, move.t_us);
  return camera && truth != nullptr && eye != nullptr && truth->position_m.allFinite() &&
         is_wrong_move(*camera, eye->root_from_left_cam(), move.target_m, truth->position_m);
}

/// The largest error from `from_s` on, or of all when it never comes to that.
double error_range_deg(const std::vector<Point>& error, double from_s) {
  double from_then = 0.0;
  double of_all = 0.0;
  for (const Point& p : error) {
    if (!std::isfinite(p.y)) continue;
    of_all = std::max(of_all, p.y);
    if (p.x >= from_s) from_then = std::max(from_then, p.y);
  }
  return std::max(3.0, 1.15 * (from_then > 0.0 ? from_then : of_all));
}

std::vector<Point> level(double y, double end_s) { return {{.x = 0.0, .y = y}, {.x = end_s, .y = y}}; }

std::string bands(std::span<const Saccade> saccades, std::int64_t start_us) {
  std::string commands;
  for (std::size_t i = 0; i < saccades.size(); ++i) {
    commands += fmt::format(
        "set object {} rect from {:.6g}, graph 0 to {:.6g}, graph 1 fc rgb '#dedaf4' fs solid noborder "
        "behind\n",
        i + 1, seconds(saccades[i].start_us, start_us), seconds(saccades[i].end_us, start_us));
  }
  return commands;
}

}  // namespace

Figure gaze_over_time_figure(std::string_view name, const GazeTables& tables,
                             const std::optional<Camera>& camera, std::optional<std::int64_t> acquired_at_us,
                             std::int64_t start_us) {
  SaccadeFinder finder;
  std::vector<Point> speed;
  for (const EyeRow& eye : tables.eye) {
    finder.add(eye.t_us, axis_of(eye));
    speed.push_back({.x = seconds(eye.t_us, start_us), .y = finder.speed_deg_s()});
  }
  const std::vector<Point> error = fixation_error(tables, start_us);
  const double end_s = tables.eye.empty() ? 0.0 : seconds(tables.eye.back().t_us, start_us);
  const double top_deg = error_range_deg(error, acquired_at_us ? seconds(*acquired_at_us, start_us) : 0.0);
  std::vector<Point> right;
  std::vector<Point> wrong;
  for (const Move& move : moves_of(tables.gaze)) {
    const double t_s = seconds(move.t_us, start_us);
    if (is_wrong(move, tables, camera)) {
      wrong.push_back({.x = t_s, .y = 0.97 * top_deg});
    } else {
      right.push_back({.x = t_s, .y = 0.02 * top_deg});
    }
  }
  const std::vector<Saccade> saccades = saccades_of(tables.eye);
  std::vector<std::array<double, 2>> fast_s;
  for (const Saccade& s : saccades)
    fast_s.push_back({seconds(s.start_us, start_us), seconds(s.end_us, start_us)});
  std::string marks = bands(saccades, start_us);
  if (acquired_at_us) {
    const double t_s = seconds(*acquired_at_us, start_us);
    marks += fmt::format(
        "set arrow 1 from {0:.6g}, graph 0 to {0:.6g}, graph 1 nohead lw 1.2 lc rgb '#555555'\nset label 1 "
        "'acquired' at {0:.6g}, graph 0.93 left offset 0.5,0 tc rgb '#555555'\n",
        t_s);
  }
  GnuplotFigure figure(name, width, 430);
  figure.set_over_x();
  figure.add_panel(
      {.x_label = std::string(time_label),
       .y_label = "fixation error [deg]",
       .z_label = "",
       .commands = "set key horizontal outside top right width -3 maxrows 1\n" + marks +
                   axes(false, fmt::format("[0:{:.6g}]", top_deg)) + time_range(0.0, end_s),
       .series = {{.title = "fixation error", .style = line_style(gaze_colour, 1.8), .points = error},
                  {.title = "on target below",
                   .style = std::string(limit_style),
                   .points = level(2.0, end_s)},
                  {.title = "gaze targets",
                   .style = dot_style(gaze_target_colour, 0.45),
                   .points = std::move(right)},
                  {.title = "wrong ones", .style = dot_style(wrong_colour, 0.6), .points = std::move(wrong)}},
       .bands = fast_s});
  figure.add_panel(
      {.x_label = std::string(time_label),
       .y_label = "eye [deg/s]",
       .z_label = "",
       .commands = "unset key\nunset label 1\n" + axes(true, "[0:*]") + time_range(0.0, end_s),
       .series = {{.title = "eye", .style = line_style(gaze_colour, 1.4), .points = std::move(speed)},
                  {.title = "saccade above",
                   .style = std::string(limit_style),
                   .points = level(Saccade::fast_deg_s, end_s)}},
       .bands = fast_s});
  return figure.draw("set multiplot layout 2,1 margins 0.095,0.985,0.13,0.915 spacing 0.0,0.04\n");
}

Figure main_sequence_figure(std::string_view name, std::span<const Saccade> saccades, std::int64_t start_us) {
  std::vector<Point> points;
  for (const Saccade& s : saccades)
    points.push_back({s.amplitude_deg, s.peak_deg_s, seconds(s.start_us, start_us)});
  GnuplotFigure figure(name, width, 300);
  figure.set_over_x();
  figure.add_panel(
      {.x_label = "size of the saccade [deg]",
       .y_label = "peak speed [deg/s]",
       .z_label = "starts at [s]",
       .commands = "unset key\nset offsets 0, graph 0.05, graph 0.1, 0\nset xrange [0:*]\nset "
                   "yrange [0:*]\n",
       .series = {{.title = "saccades", .style = dot_style(gaze_colour, 0.6), .points = std::move(points)}}});
  return figure.draw();
}

namespace {

/// Points of the root frame with their times, s.
struct RootPath {
  std::string title;
  std::string style;
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> points_m;

  void add(std::int64_t t_us, std::int64_t start_us, const Eigen::Vector3d& point_m) {
    t_s.push_back(seconds(t_us, start_us));
    points_m.push_back(point_m);
  }
};

RootPath fixation_path(const GazePath& gaze) {
  const GazeTables& tables = gaze.tables;
  RootPath path{.title = "fixation point", .style = line_style(gaze_colour, 1.2), .t_s = {}, .points_m = {}};
  std::int64_t converged = 0;
  for (const GazeRow& row : tables.gaze) {
    converged += row.fixation_m.allFinite() ? 1 : 0;
    path.add(row.t_us, gaze.start_us, row.fixation_m);
  }
  if (2 * converged >= std::ssize(tables.gaze) || tables.eye.empty() || tables.truth.empty()) return path;
  path = {.title = "left eye's axis at the ball's distance", .style = path.style, .t_s = {}, .points_m = {}};
  for (const EyeRow& eye : tables.eye) {
    const TruthRow* truth = row_at(tables.truth, eye.t_us);
    if (truth == nullptr) continue;
    const double distance_m = (truth->position_m - eye.position_m).norm();
    path.add(eye.t_us, gaze.start_us, eye.position_m + distance_m * axis_of(eye));
  }
  return path;
}

std::vector<RootPath> paths_of(const GazePath& gaze) {
  RootPath ball{.title = "ball", .style = line_style(truth_colour, 3.0), .t_s = {}, .points_m = {}};
  for (const TruthRow& row : gaze.tables.truth) ball.add(row.t_us, gaze.start_us, row.position_m);
  RootPath targets{
      .title = "gaze targets", .style = dot_style(gaze_target_colour, 0.55), .t_s = {}, .points_m = {}};
  for (const Move& move : moves_of(gaze.tables.gaze)) targets.add(move.t_us, gaze.start_us, move.target_m);
  return {std::move(ball), std::move(targets), fixation_path(gaze)};
}

/// What lies within all panels: the balls' paths and 8 cm around them; the targets' where there is no ball.
Eigen::AlignedBox3d box_of(const std::vector<std::vector<RootPath>>& drawn) {
  Eigen::AlignedBox3d box;
  for (const std::size_t source : {std::size_t{0}, std::size_t{1}}) {
    for (const auto& paths : drawn) {
      for (const Eigen::Vector3d& p : paths[source].points_m) {
        if (p.allFinite()) box.extend(p);
      }
    }
    if (!box.isEmpty()) break;
  }
  if (box.isEmpty()) box.extend(Eigen::Vector3d(-0.4, 0.0, 0.35));
  const Eigen::Vector3d margin_m = Eigen::Vector3d::Constant(0.08);
  return {box.min() - margin_m, box.max() + margin_m};
}

/// Layout of the panels, in the drawing's pixels.
constexpr int panel_left_px = 66;
constexpr int panel_gap_px = 84;
constexpr int panel_wide_px = (width - panel_left_px - panel_gap_px - 14) / 2;
constexpr int panel_top_px = 78;
constexpr int panel_bottom_px = 64;
constexpr int panel_between_px = 92;
constexpr double smallest_half_m = 0.15;

}  // namespace

Figure gaze_paths_figure(std::string_view name, std::span<const GazePath> gazes) {
  std::vector<std::vector<RootPath>> paths;
  for (const GazePath& gaze : gazes) paths.push_back(paths_of(gaze));
  const Eigen::AlignedBox3d box = box_of(paths);
  const Eigen::Vector3d middle_m = box.center();
  const double half_wide_m = std::max({smallest_half_m, 0.5 * box.sizes().x(), 0.5 * box.sizes().y()});
  const double half_high_m = std::max(smallest_half_m, 0.5 * box.sizes().z());
  const int panel_high_px = static_cast<int>(std::lround(panel_wide_px * half_high_m / half_wide_m));
  const int rows = std::max(1, static_cast<int>(std::ssize(gazes)));
  const int height = panel_top_px + rows * panel_high_px + (rows - 1) * panel_between_px + panel_bottom_px;
  const auto range = [](char axis, double middle, double half) {
    return fmt::format("set {0}range [{1:.6g}:{2:.6g}]\nset {0}tics {3}\n", axis, middle - half,
                       middle + half,
                       half > 0.3    ? 0.2
                       : half > 0.12 ? 0.1
                                     : 0.05);
  };

  GnuplotFigure figure(name, width, height);
  for (std::size_t i = 0; i < gazes.size(); ++i) {
    const auto panel = [&](bool front) {
      std::vector<Series> series;
      for (const RootPath& path : paths[i]) {
        Series drawn{.title = path.title, .style = path.style, .points = {}, .in_key = true};
        for (const Eigen::Vector3d& p : path.points_m)
          drawn.points.push_back({.x = front ? p.y() : -p.x(), .y = p.z()});
        series.push_back(std::move(drawn));
      }
      figure.add_panel(
          {.x_label = front ? "y [m], right" : "-x [m], ahead",
           .y_label = "z [m], up",
           .z_label = "",
           .commands =
               (front ? fmt::format("set label 1 {} at graph 0, graph 1 left offset 0,0.8\n",
                                    gnuplot_quoted(gazes[i].label))
                      : std::string("unset label 1\n")) +
               (i == 0 && front
                    ? "set key horizontal at screen 0.985, screen 0.995 right top width -3 maxrows 1\n"
                    : "unset key\n") +
               "set xlabel offset 0,0.4\n" + range('x', front ? middle_m.y() : -middle_m.x(), half_wide_m) +
               range('y', middle_m.z(), half_high_m),
           .series = std::move(series)});
    };
    panel(true);
    panel(false);
  }
  Figure drawn = figure.draw(fmt::format(
      "set multiplot layout {},2 margins {:.6g},{:.6g},{:.6g},{:.6g} spacing {:.6g},{:.6g}\n", rows,
      static_cast<double>(panel_left_px) / width,
      static_cast<double>(panel_left_px + 2 * panel_wide_px + panel_gap_px) / width,
      static_cast<double>(panel_bottom_px) / height, 1.0 - static_cast<double>(panel_top_px) / height,
      static_cast<double>(panel_gap_px) / width, static_cast<double>(panel_between_px) / height));
  drawn.csv = "series,run,time [s],x [m],y [m],z [m]\n";
  for (std::size_t i = 0; i < gazes.size(); ++i) {
    for (const RootPath& path : paths[i]) {
      for (std::size_t k = 0; k < path.points_m.size(); ++k) {
        const Eigen::Vector3d& p = path.points_m[k];
        if (!p.allFinite()) continue;
        drawn.csv += fmt::format("{},{},{:.9g},{:.9g},{:.9g},{:.9g}\n", csv_field(path.title),
                                 csv_field(gazes[i].label), path.t_s[k], p.x(), p.y(), p.z());
      }
    }
  }
  return drawn;
}

Figure joints_figure(std::string_view name, std::span<const GazeRow> gaze, const JointLimits& limits,
                     std::int64_t start_us) {
  const double end_s = gaze.empty() ? 0.0 : seconds(gaze.back().t_us, start_us);
  GnuplotFigure figure(name, width, 560);
  figure.set_over_x();
  std::vector<HeadJoint> joints;
  for (const HeadJoint& shown : limits.head->joints) {
    if (shown.role != JointRole::torso) joints.push_back(shown);
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int j = joints[i].slot;
    std::string joint = joints[i].name;
    std::replace(joint.begin(), joint.end(), '_', ' ');
    const bool bottom = i + 2 >= joints.size();
    const double span_deg = 1e-9 + (limits.max_rad[j] - limits.min_rad[j]) * deg_per_rad;
    const std::string range =
        fmt::format("[{:.6g}:{:.6g}]", limits.min_rad[j] * deg_per_rad - 0.06 * span_deg,
                    limits.max_rad[j] * deg_per_rad + 0.06 * span_deg);
    figure.add_panel({.x_label = std::string(time_label),
                      .y_label = joint + " [deg]",
                      .z_label = "",
                      .commands = "unset key\n" + axes(bottom, range) + time_range(0.0, end_s),
                      .series = {{.title = "measured",
                                  .style = line_style(gaze_colour, 2.0),
                                  .points = over_time(
                                      gaze, start_us,
                                      [&](const GazeRow& row) { return row.position_rad[j] * deg_per_rad; })},
                                 {.title = "lower limit",
                                  .style = std::string(joint_limit_style),
                                  .points = level(limits.min_rad[j] * deg_per_rad, end_s)},
                                 {.title = "upper limit",
                                  .style = std::string(joint_limit_style),
                                  .points = level(limits.max_rad[j] * deg_per_rad, end_s)}}});
  }
  return figure.draw(
      fmt::format("set multiplot layout {},2 margins 0.085,0.985,0.12,0.97 spacing 0.10,0.04\n",
                  (joints.size() + 1) / 2));
}

}  // namespace saccade
