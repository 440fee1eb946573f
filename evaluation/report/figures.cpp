#include "evaluation/report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "evaluation/report/figure_parts.h"

namespace saccade {

using namespace figure_parts;

std::string detector_colour(std::size_t index) {
  // Most are told apart also by those who do not see red and green alike (Okabe and Ito's palette first).
  static constexpr std::array<std::string_view, 10> colours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                               "#56b4e9", "#e69f00", "#6a3d9a", "#8b5a2b",
                                                               "#8c8c8c", "#7a9a01"};
  return std::string(colours[index % colours.size()]);
}

Figure tracking_figure(std::string_view name, std::span<const TruthRow> truth,
                       std::span<const DetectionRow> detections, std::string_view detector, double threshold,
                       std::string_view colour, bool sparse, std::int64_t start_us) {
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
    figure.add_panel({.x_label = std::string(time_label),
                      .y_label = q.label,
                      .z_label = "",
                      .commands = axes(last) + time_range(0.0, end_s) +
                                  (first ? "set key horizontal outside top right\n" : "unset key\n"),
                      .series = {{.title = std::string(detector),
                                  .style = dot_style(colour),
                                  .points = over_time(accepted, start_us, circle_value)},
                                 {.title = "truth",
                                  .style = sparse ? "points pt 6 ps 0.6 lw 1.5 lc rgb '#222222'"
                                                  : std::string(truth_style),
                                  .points = over_time(truth, start_us, truth_value)}}});
  }
  return figure.draw(stacked(3));
}

constexpr std::string_view precision_recall_axes =
    "set xrange [0:1]\nset yrange [0:1.03]\nset key outside right top\n";

std::vector<Point> curve_points(const DetectorScore& score) {
  std::vector<Point> points;
  for (const CurvePoint& p : score.pr_curve) points.push_back({p.recall, p.precision, p.threshold});
  return points;
}

std::string square_style(std::string_view colour) {
  return fmt::format("points pt 5 ps 1.1 lc rgb '{}'", colour);
}

Figure precision_recall_figure(std::string_view name, const Metrics& metrics) {
  std::vector<Series> series;
  for (std::size_t i = 0; i < metrics.detectors.size(); ++i) {
    const auto& [detector, score] = metrics.detectors[i];
    series.push_back(
        {.title = detector, .style = line_style(detector_colour(i), 2.0), .points = curve_points(score)});
    if (score.recall && score.precision) {
      series.push_back({.title = detector + ", its threshold",
                        .style = square_style(detector_colour(i)),
                        .points = {{*score.recall, *score.precision, score.threshold}},
                        .in_key = false});
    }
  }
  GnuplotFigure figure(name, width, 420);
  figure.add_panel({.x_label = "recall",
                    .y_label = "precision",
                    .z_label = "threshold",
                    .commands = std::string(precision_recall_axes),
                    .series = std::move(series)});
  return figure.draw();
}

namespace {

constexpr std::int64_t rate_bin_us = 100'000;
constexpr std::string_view frame_camera = "frame_30hz";
constexpr double frame_camera_hz = 30.0;

/// The most that a 30 Hz camera can give, where no detector stands for one.
void add_frame_camera(std::vector<Series>& series, bool simulated, double from, double to) {
  if (simulated) return;
  series.push_back({.title = "30 Hz frames at best",
                    .style = "lines lw 1.6 dt 2 lc rgb '#8b5a2b'",
                    .points = {{.x = from, .y = frame_camera_hz}, {.x = to, .y = frame_camera_hz}}});
}

/// Counts per second in the whole 100 ms bins from `first_us` on; a bin nobody looked into is a gap.
class RateBins {
 public:
  RateBins(std::int64_t first_us, std::int64_t end_us)
      : first_us_(first_us),
        points_(static_cast<std::size_t>(std::max<std::int64_t>(0, end_us - first_us) / rate_bin_us)) {
    for (Point& point : points_) point.y = nan;
  }
  void look(std::int64_t t_us, bool found) {
    const std::int64_t bin = (t_us - first_us_) / rate_bin_us;
    if (t_us < first_us_ || bin >= std::ssize(points_)) return;
    double& rate_hz = points_[static_cast<std::size_t>(bin)].y;
    rate_hz = (std::isnan(rate_hz) ? 0.0 : rate_hz) + (found ? 1e6 / static_cast<double>(rate_bin_us) : 0.0);
  }
  [[nodiscard]] std::vector<Point> points(std::int64_t start_us) && {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      points_[i].x =
          seconds(first_us_ + static_cast<std::int64_t>(i) * rate_bin_us + rate_bin_us / 2, start_us);
    }
    return std::move(points_);
  }

 private:
  std::int64_t first_us_;
  std::vector<Point> points_;
};

std::vector<Point> event_rate(const EventCounts& events, std::int64_t start_us) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < events.counts.size(); ++i) {
    const auto middle_us = events.start_us + static_cast<std::int64_t>(i) * events.bin_us + events.bin_us / 2;
    points.push_back({.x = seconds(middle_us, start_us),
                      .y = static_cast<double>(events.counts[i]) * 1e3 / static_cast<double>(events.bin_us)});
  }
  return points;
}

std::vector<Point> detection_rate(std::span<const TruthRow> truth, std::span<const std::optional<bool>> found,
                                  std::int64_t start_us) {
  RateBins bins(truth.front().t_us, truth.back().t_us + 1'000);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i]) bins.look(truth[i].t_us, *found[i]);
  }
  return std::move(bins).points(start_us);
}

std::vector<Point> accepted_rate(std::span<const DetectionRow> detections, std::string_view detector,
                                 double threshold, std::int64_t start_us, double duration_s) {
  const std::int64_t end_us = start_us + std::llround(std::max(duration_s, 0.0) * 1e6);
  RateBins bins(start_us, end_us);
  for (std::int64_t t_us = start_us; t_us < end_us; t_us += rate_bin_us) bins.look(t_us, false);
  for (const DetectionRow& d : detections) {
    if (d.detector == detector && d.score >= threshold) bins.look(d.t_us, true);
  }
  return std::move(bins).points(start_us);
}

/// A list of the series beside the panels, in colour: gnuplot's own key takes no more rows than its panel has
/// room for.
std::string side_key(const std::vector<Series>& series, int height) {
  std::string commands;
  for (std::size_t i = 0; i < series.size(); ++i) {
    const std::string& style = series[i].style;
    commands += fmt::format(
        "set label {} {} at screen 0.825, screen {:.6g} left point pt 5 ps 0.8 {} offset 0.9,0\n", i + 1,
        gnuplot_quoted(series[i].title), 1.0 - (24.0 + 19.0 * static_cast<double>(i)) / height,
        style.substr(style.find("lc rgb")));
  }
  return commands;
}

bool has_frame_camera(const Metrics& metrics) {
  return std::any_of(metrics.detectors.begin(), metrics.detectors.end(),
                     [](const auto& d) { return d.first == frame_camera; });
}

}  // namespace

Figure rates_figure(std::string_view name, const EventCounts* events, std::span<const TruthRow> truth,
                    std::span<const std::vector<std::optional<bool>>> found,
                    std::span<const DetectionRow> detections, const Metrics& metrics, std::int64_t start_us) {
  const bool scored = !truth.empty() && !found.empty();
  SACCADE_CHECK(found.empty() || found.size() == metrics.detectors.size());
  std::vector<Series> rates;
  for (std::size_t i = 0; i < metrics.detectors.size(); ++i) {
    const auto& [detector, score] = metrics.detectors[i];
    rates.push_back({.title = detector,
                     .style = line_style(detector_colour(i)),
                     .points = scored ? detection_rate(truth, found[i], start_us)
                                      : accepted_rate(detections, detector, score.threshold, start_us,
                                                      metrics.duration_s)});
  }
  if (scored) add_frame_camera(rates, has_frame_camera(metrics), 0.0, metrics.duration_s);

  const bool with_events = events != nullptr;
  const int count = 1 + (with_events ? 1 : 0) + (scored ? 1 : 0);
  const int height = 60 + 170 * count;
  std::vector<GnuplotFigure::Panel> panels;
  if (with_events) {
    panels.push_back({.x_label = {},
                      .y_label = "events [1/ms]",
                      .z_label = {},
                      .commands = "unset key\n",
                      .series = {{.title = "events",
                                  .style = line_style("#555555", 1.2),
                                  .points = event_rate(*events, start_us)}}});
  }
  panels.push_back({.x_label = {},
                    .y_label = scored ? "detections [1/s]" : "accepted [1/s]",
                    .z_label = {},
                    .commands = "unset key\n" + side_key(rates, height),
                    .series = std::move(rates)});
  if (scored) {
    std::vector<Point> speed;
    const std::vector<double> speed_px_s = image_speed_px_s(truth);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      speed.push_back({.x = seconds(truth[i].t_us, start_us), .y = found.front()[i] ? speed_px_s[i] : nan});
    }
    panels.push_back(
        {.x_label = {},
         .y_label = "ball [px/s]",
         .z_label = {},
         .commands = "unset key\nunset label\n",
         .series = {{.title = "ball", .style = line_style("#7b3fa0", 1.6), .points = std::move(speed)}}});
  }
  const std::size_t rates_panel = with_events ? 1 : 0;
  GnuplotFigure figure(name, width, height);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    panels[i].x_label = time_label;
    panels[i].commands += axes(i + 1 == panels.size(), i == rates_panel && scored ? "[0:1050]" : "[0:*]") +
                          time_range(0.0, metrics.duration_s);
    figure.add_panel(std::move(panels[i]));
  }
  return figure.draw(stacked(count, 0.8));
}

Figure rate_over_speed_figure(std::string_view name, std::span<const DetectorSpeeds> detectors) {
  constexpr auto& bounds = SpeedCounts::bounds_px_s;
  const double bin_ratio = bounds[2] / bounds[1];
  std::vector<Series> series;
  double fastest = bounds[1];
  double most_hz = frame_camera_hz;
  bool frames = false;
  for (const auto& [detector, counts] : detectors) {
    frames |= detector.name == frame_camera;
    std::vector<Point> points;
    for (std::size_t bin = 0; bin < bounds.size(); ++bin) {
      const std::optional<double> rate_hz = counts.rate_hz(bin);
      const double from = bin == 0 ? bounds[1] / bin_ratio : bounds[bin];
      const double to = bin + 1 < bounds.size() ? bounds[bin + 1] : bounds[bin] * bin_ratio;
      points.push_back(
          {std::sqrt(from * to), rate_hz.value_or(nan), static_cast<double>(counts.chances[bin]) * 1e-3});
      if (!rate_hz) continue;
      fastest = std::max(fastest, to);
      most_hz = std::max(most_hz, *rate_hz);
    }
    series.push_back({.title = detector.name,
                      .style = fmt::format("linespoints pt 7 ps 0.5 lw 2 lc rgb '{}'", detector.colour),
                      .points = std::move(points)});
  }
  const double slowest = bounds[1] / bin_ratio;
  add_frame_camera(series, frames, slowest, fastest);
  GnuplotFigure figure(name, width, 340);
  figure.add_panel(
      {.x_label = "speed of the ball in the image [px/s]",
       .y_label = "detections [1/s]",
       .z_label = "time at that speed [s]",
       .commands = fmt::format(
           "set logscale x\nset xrange [{:.6g}:{:.6g}]\nset xtics ('below 10' {:.6g}, 20, 40, 80, "
           "160, 320, 640, 1280)\nset yrange [0:{:.6g}]\nset key outside right top\n",
           slowest, fastest, std::sqrt(slowest * bounds[1]), std::min(1050.0, 1.15 * most_hz)),
       .series = std::move(series)});
  return figure.draw();
}

namespace {

/// Mean over the runs of the precision at the highest threshold whose recall reaches R, for R = 0.01, 0.02,
/// ... as far as every run with a curve gets.
std::vector<Point> mean_curve(const std::vector<DetectorScore>& scores) {
  std::vector<Point> mean;
  for (int percent = 1; percent <= 100; ++percent) {
    const double recall = percent * 0.01;
    double sum = 0.0;
    double runs = 0.0;
    for (const DetectorScore& score : scores) {
      if (score.pr_curve.empty()) continue;
      const auto reached = std::find_if(score.pr_curve.begin(), score.pr_curve.end(),
                                        [&](const CurvePoint& p) { return p.recall >= recall; });
      if (reached == score.pr_curve.end()) return mean;
      sum += reached->precision;
      runs += 1.0;
    }
    if (runs == 0.0) return mean;
    mean.push_back({recall, sum / runs, nan});
  }
  return mean;
}

template <class Member>
MeanSd over_runs(const std::vector<DetectorScore>& scores, Member member) {
  std::vector<std::optional<double>> values;
  for (const DetectorScore& score : scores) values.push_back(score.*member);
  return mean_sd_of(values);
}

std::string transparent(std::string_view colour) { return fmt::format("#90{}", colour.substr(1)); }

}  // namespace

Figure precision_recall_spread_figure(std::string_view name, std::span<const DetectorRuns> detectors) {
  std::vector<Series> thin;
  std::vector<Series> thick;
  for (const auto& [detector, scores] : detectors) {
    const bool several = scores.size() > 1;
    for (std::size_t run = 0; several && run < scores.size(); ++run) {
      thin.push_back({.title = fmt::format("{}, run {}", detector.name, run + 1),
                      .style = line_style(transparent(detector.colour), 0.8),
                      .points = curve_points(scores[run]),
                      .in_key = false});
    }
    thick.push_back({.title = detector.name,
                     .style = line_style(detector.colour, 2.2),
                     .points = several ? mean_curve(scores) : curve_points(scores.front())});
    const MeanSd precision = over_runs(scores, &DetectorScore::precision);
    const MeanSd recall = over_runs(scores, &DetectorScore::recall);
    if (precision.mean && recall.mean) {
      thick.push_back({.title = detector.name + ", its threshold",
                       .style = square_style(detector.colour),
                       .points = {{*recall.mean, *precision.mean, scores.front().threshold}},
                       .in_key = false});
    }
  }
  thin.insert(thin.end(), std::make_move_iterator(thick.begin()), std::make_move_iterator(thick.end()));
  GnuplotFigure figure(name, width, 420);
  figure.add_panel({.x_label = "recall",
                    .y_label = "precision",
                    .z_label = "threshold",
                    .commands = std::string(precision_recall_axes),
                    .series = std::move(thin)});
  return figure.draw();
}

Figure average_precision_figure(std::string_view name, std::span<const RunGroup> groups) {
  std::size_t rows = 1;
  for (const RunGroup& group : groups) rows = std::max(rows, group.detectors.size());
  const int count = std::max(1, static_cast<int>(std::ssize(groups)));
  constexpr int bottom_px = 62;
  constexpr int top_px = 28;
  const int panel_px = 16 + top_px + 20 * static_cast<int>(rows);
  const int height = bottom_px + count * panel_px;
  GnuplotFigure figure(name, width, height);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto& [label, detectors] = groups[g];
    std::string tics;
    std::vector<Series> series;
    for (std::size_t i = 0; i < detectors.size(); ++i) {
      const auto& [detector, scores] = detectors[i];
      const double y = -static_cast<double>(i);
      tics += fmt::format("{}{} {}", tics.empty() ? "" : ", ", gnuplot_quoted(detector.name), y);
      std::vector<Point> dots;
      for (const DetectorScore& score : scores) {
        if (score.average_precision) dots.push_back({.x = *score.average_precision, .y = y});
      }
      const MeanSd mean = over_runs(scores, &DetectorScore::average_precision);
      if (mean.sd) {
        series.push_back(
            {.title = fmt::format("{}: {}, mean -+ sd", label, detector.name),
             .style = line_style(transparent(detector.colour), 7.0),
             .points = {{.x = *mean.mean - *mean.sd, .y = y}, {.x = *mean.mean + *mean.sd, .y = y}},
             .in_key = false});
      }
      series.push_back({.title = fmt::format("{}: {}", label, detector.name),
                        .style = dot_style(detector.colour, 0.6),
                        .points = std::move(dots),
                        .in_key = false});
    }
    figure.add_panel(
        {.x_label = "average precision",
         .y_label = "",
         .z_label = {},
         .commands = fmt::format("set xrange [0:1]\nset yrange [{}:0.6]\nset ytics ({})\nunset "
                                 "label\nset label 1 {} at graph "
                                 "0, screen {:.6g} left\n{}",
                                 0.4 - static_cast<double>(rows), tics, gnuplot_quoted(label),
                                 1.0 - (static_cast<double>(g) * panel_px + 16.0) / height,
                                 g + 1 == groups.size() ? "set xlabel offset 0,0.4\nset format x '%g'\n"
                                                        : "unset xlabel\nset format x ''\n"),
         .series = std::move(series)});
  }
  Figure drawn = figure.draw(
      fmt::format("set multiplot layout {},1 margins 0.19,0.97,{:.6g},{:.6g} spacing 0.0,{:.6g}\n", count,
                  static_cast<double>(bottom_px) / height, 1.0 - static_cast<double>(top_px) / height,
                  static_cast<double>(top_px) / height));
  drawn.csv = "group,detector,run,average precision\n";
  for (const auto& [label, detectors] : groups) {
    for (const auto& [detector, scores] : detectors) {
      for (std::size_t run = 0; run < scores.size(); ++run) {
        const std::optional<double> value = scores[run].average_precision;
        drawn.csv += fmt::format("{},{},{},{}\n", csv_field(label), csv_field(detector.name), run + 1,
                                 value ? fmt::format("{:.9g}", *value) : "");
      }
    }
  }
  return drawn;
}

}  // namespace saccade
