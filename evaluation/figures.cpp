#include "evaluation/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "evaluation/gnuplot.h"

namespace saccade {
namespace {

using Point = GnuplotFigure::Point;
using Series = GnuplotFigure::Series;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double deg_per_rad = 180.0 / std::numbers::pi;
constexpr std::string_view truth_style = "lines lw 1.4 lc rgb '#222222'";
constexpr int width = 900;

double seconds(std::int64_t t_us, std::int64_t start_us) {
  return static_cast<double>(t_us - start_us) * 1e-6;
}

template <class Rows, class Value>
std::vector<Point> over_time(const Rows& rows, std::int64_t start_us, Value value) {
  std::vector<Point> points;
  for (const auto& row : rows) points.push_back({.x = seconds(row.t_us, start_us), .y = value(row)});
  return points;
}

std::vector<Point> in_space(const std::vector<Eigen::Vector3d>& path_m) {
  std::vector<Point> points;
  for (const Eigen::Vector3d& p : path_m) points.push_back({p.x(), p.y(), p.z()});
  return points;
}

std::string line_style(std::string_view colour, double line_width = 1.6) {
  return fmt::format("lines lw {} lc rgb '{}'", line_width, colour);
}

std::string dot_style(std::string_view colour, double size = 0.3) {
  return fmt::format("points pt 7 ps {} lc rgb '{}'", size, colour);
}

/// Panels one above the other with a common time axis under the last.
std::string stacked(int panels) {
  return fmt::format("set multiplot layout {},1 margins 0.095,0.985,{},{} spacing 0.0,0.035\n", panels,
                     panels > 2 ? 0.13 : 0.155, panels > 2 ? 0.94 : 0.97);
}

std::string time_range(double from_s, double to_s) {
  return to_s > from_s ? fmt::format("set xrange [{:.6g}:{:.6g}]\n", from_s, to_s) : std::string();
}

std::string axes(std::string_view y_label, bool last, std::string_view y_range = "[*:*]") {
  return fmt::format(
      "set ylabel '{}'\nset offsets 0, 0, graph 0.06, {}\nset yrange {}\n{}", y_label,
      y_range == "[*:*]" ? "graph 0.06" : "0", y_range,
      last ? "set xlabel 'time [s]' offset 0,0.4\nset format x '%g'\n" : "unset xlabel\nset format x ''\n");
}

}  // namespace

std::string detector_colour(std::size_t index) {
  // Told apart also by those who do not see red and green alike (Okabe and Ito's palette).
  static constexpr std::array<std::string_view, 7> colours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                              "#56b4e9", "#e69f00", "#000000"};
  return std::string(colours[index % colours.size()]);
}

std::string tracking_figure(std::string_view name, std::span<const TruthRow> truth,
                            std::span<const DetectionRow> detections, std::string_view detector,
                            double threshold, std::string_view colour, bool sparse, std::int64_t start_us) {
  std::vector<DetectionRow> accepted;
  std::copy_if(detections.begin(), detections.end(), std::back_inserter(accepted),
               [&](const DetectionRow& d) { return d.detector == detector && d.score >= threshold; });
  struct Quantity {
    const char* label;
    double Circle::*member;
  };
  GnuplotFigure figure(name, width, 520);
  for (const Quantity& q :
       {Quantity{"x [px]", &Circle::x_px}, {"y [px]", &Circle::y_px}, {"r [px]", &Circle::r_px}}) {
    const bool last = q.member == &Circle::r_px;
    const auto circle_value = [&](const auto& row) { return row.circle.*q.member; };
    const auto truth_value = [&](const TruthRow& row) {
      return row.visible >= chance_visible_share ? circle_value(row) : nan;
    };
    double end_s = 0.0;
    if (!truth.empty()) end_s = seconds(truth.back().t_us, start_us);
    if (!accepted.empty()) end_s = std::max(end_s, seconds(accepted.back().t_us, start_us));
    const bool first = q.member == &Circle::x_px;
    figure.add_panel(
        axes(q.label, last) + time_range(0.0, end_s) +
            (first ? "set key horizontal outside top right\n" : "unset key\n"),
        {{.title = std::string(detector),
          .style = dot_style(colour),
          .points = over_time(accepted, start_us, circle_value)},
         {.title = "truth",
          .style = sparse ? "points pt 6 ps 0.6 lw 1.5 lc rgb '#222222'" : std::string(truth_style),
          .points = over_time(truth, start_us, truth_value)}});
  }
  return figure.svg(stacked(3));
}

std::string precision_recall_figure(std::string_view name, const Metrics& metrics) {
  GnuplotFigure figure(name, width, 420);
  std::vector<Series> series;
  for (std::size_t i = 0; i < metrics.detectors.size(); ++i) {
    const auto& [detector, score] = metrics.detectors[i];
    std::vector<Point> curve;
    for (const CurvePoint& p : score.pr_curve) curve.push_back({.x = p.recall, .y = p.precision});
    series.push_back({.title = detector, .style = line_style(detector_colour(i), 2.0), .points = curve});
    if (score.recall && score.precision) {
      series.push_back({.title = "",
                        .style = fmt::format("points pt 5 ps 1.1 lc rgb '{}'", detector_colour(i)),
                        .points = {{.x = *score.recall, .y = *score.precision}}});
    }
  }
  figure.add_panel(
      "set xrange [0:1]\nset yrange [0:1.03]\nset xlabel 'recall'\nset ylabel 'precision'\nset key outside "
      "right top\n",
      series);
  return figure.svg();
}

std::string gaze_path_figure(std::string_view name, std::span<const TruthRow> truth,
                             std::span<const GazeRow> gaze) {
  // Right, ahead and up, as seen from behind the head.
  const auto from_behind = [](const Eigen::Vector3d& root_m) {
    return Eigen::Vector3d(root_m.y(), -root_m.x(), root_m.z());
  };
  std::vector<Eigen::Vector3d> ball;
  for (const TruthRow& row : truth) ball.push_back(from_behind(row.position_m));
  std::vector<Eigen::Vector3d> fixation;
  std::vector<Eigen::Vector3d> targets;  // where it moves, not every tick on which it holds
  for (const GazeRow& row : gaze) {
    fixation.push_back(from_behind(row.fixation_m));
    const Eigen::Vector3d target = from_behind(row.target_m);
    if (target.allFinite() && (targets.empty() || (target - targets.back()).norm() > 1e-3)) {
      targets.push_back(target);
    }
  }

  // A cube that holds the ball's path and 8 cm around it; eyes that look far away fixate a point far away.
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const Eigen::Vector3d& p : ball) {
    if (!p.allFinite()) continue;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  std::string ranges;
  const double half_m = 0.5 * (high - low).maxCoeff() + 0.08;
  for (int axis = 0; half_m > 0.0 && axis < 3; ++axis) {
    const double middle_m = 0.5 * (low[axis] + high[axis]);
    ranges += fmt::format("set {0}range [{1:.6g}:{2:.6g}]\nset {0}tics {3}\n", "xyz"[axis], middle_m - half_m,
                          middle_m + half_m, half_m > 0.25 ? 0.2 : 0.1);
  }

  GnuplotFigure figure(name, width, 560);
  figure.add_panel(
      ranges +
          "set xlabel 'y [m], right'\nset ylabel '-x [m], ahead' offset 3,0\nset zlabel 'z [m], up' rotate "
          "parallel\nset view 65,20,1.1\nset view equal xyz\nset xyplane relative 0\nset grid z\nset key at "
          "screen 0.98,0.96\nset border 127 lc rgb '#bbbbbb'\n",
      {{.title = "ball", .style = line_style("#9a9a9a", 3.0), .points = in_space(ball)},
       {.title = "gaze targets", .style = dot_style("#d55e00", 0.35), .points = in_space(targets)},
       {.title = "fixation point", .style = line_style("#0072b2"), .points = in_space(fixation)}},
      true);
  return figure.svg();
}

std::string fixation_figure(std::string_view name, std::span<const TruthRow> truth,
                            const PinholeCamera& camera, std::int64_t start_us) {
  const auto angle_deg = [&](const TruthRow& row) {
    const Eigen::Vector3d ray = camera.ray(row.circle.x_px, row.circle.y_px);
    return std::atan(ray.head<2>().norm()) * deg_per_rad;
  };
  const double end_s = truth.empty() ? 0.0 : seconds(truth.back().t_us, start_us);
  GnuplotFigure figure(name, width, 260);
  figure.add_panel(axes("fixation error [deg]", true, "[0:*]") + time_range(0.0, end_s),
                   {{.title = "ball off the optical axis",
                     .style = line_style("#0072b2", 2.0),
                     .points = over_time(truth, start_us, angle_deg)},
                    {.title = "on target below 2 deg",
                     .style = "lines lw 1.2 dt 2 lc rgb '#777777'",
                     .points = {{.x = 0.0, .y = 2.0}, {.x = end_s, .y = 2.0}}}});
  return figure.svg();
}

std::string joints_figure(std::string_view name, std::span<const GazeRow> gaze, const JointLimits& limits,
                          std::int64_t start_us) {
  const double end_s = gaze.empty() ? 0.0 : seconds(gaze.back().t_us, start_us);
  GnuplotFigure figure(name, width, 560);
  for (int j = torso_joint_count; j < joint_count; ++j) {
    const auto level = [&](double rad) {
      return std::vector<Point>{{.x = 0.0, .y = rad * deg_per_rad}, {.x = end_s, .y = rad * deg_per_rad}};
    };
    const std::string limit_style = "lines lw 1.6 dt 2 lc rgb '#d55e00'";
    std::string joint(joint_names[static_cast<std::size_t>(j)]);
    std::replace(joint.begin(), joint.end(), '_', ' ');
    const bool bottom = j >= joint_count - 2;
    const double span_deg = 1e-9 + (limits.max_rad[j] - limits.min_rad[j]) * deg_per_rad;
    figure.add_panel(
        "unset key\n" +
            axes(joint + " [deg]", bottom,
                 fmt::format("[{:.6g}:{:.6g}]", limits.min_rad[j] * deg_per_rad - 0.06 * span_deg,
                             limits.max_rad[j] * deg_per_rad + 0.06 * span_deg)) +
            time_range(0.0, end_s),
        {{.title = "",
          .style = line_style("#0072b2", 2.0),
          .points = over_time(gaze, start_us,
                              [&](const GazeRow& row) { return row.position_rad[j] * deg_per_rad; })},
         {.title = "", .style = limit_style, .points = level(limits.min_rad[j])},
         {.title = "", .style = limit_style, .points = level(limits.max_rad[j])}});
  }
  return figure.svg("set multiplot layout 3,2 margins 0.085,0.985,0.12,0.97 spacing 0.10,0.04\n");
}

std::string rates_figure(std::string_view name, const EventCounts& events,
                         std::span<const DetectionRow> detections, const Metrics& metrics,
                         std::int64_t start_us) {
  std::vector<Point> event_rate;
  for (std::size_t i = 0; i < events.counts.size(); ++i) {
    const auto middle_us = events.start_us + static_cast<std::int64_t>(i) * events.bin_us + events.bin_us / 2;
    event_rate.push_back(
        {.x = seconds(middle_us, start_us),
         .y = static_cast<double>(events.counts[i]) * 1e3 / static_cast<double>(events.bin_us)});
  }
  constexpr std::int64_t bin_us = 100'000;
  std::vector<Series> rates;
  for (std::size_t i = 0; i < metrics.detectors.size(); ++i) {
    const auto& [detector, score] = metrics.detectors[i];
    std::vector<Point> rate(static_cast<std::size_t>(std::max(metrics.duration_s, 0.0) * 1e6 / bin_us) + 1);
    for (std::size_t b = 0; b < rate.size(); ++b) rate[b].x = (static_cast<double>(b) + 0.5) * 1e-6 * bin_us;
    for (const DetectionRow& d : detections) {
      const std::int64_t bin = (d.t_us - start_us) / bin_us;
      if (d.detector == detector && d.score >= score.threshold && bin >= 0 && bin < std::ssize(rate)) {
        rate[static_cast<std::size_t>(bin)].y += 1e6 / bin_us;
      }
    }
    rates.push_back({.title = detector, .style = line_style(detector_colour(i)), .points = std::move(rate)});
  }
  GnuplotFigure figure(name, width, 420);
  const std::string range = time_range(0.0, metrics.duration_s);
  figure.add_panel("unset key\n" + axes("events [1/ms]", false, "[0:*]") + range,
                   {{.title = "", .style = line_style("#555555", 1.2), .points = std::move(event_rate)}});
  figure.add_panel("set key top right\n" + axes("accepted [1/s]", true, "[0:*]") + range, rates);
  return figure.svg(stacked(2));
}

}  // namespace saccade
