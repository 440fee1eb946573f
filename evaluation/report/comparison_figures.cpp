#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "evaluation/report/figure_parts.h"
#include "evaluation/report/figures.h"

namespace saccade {

using namespace figure_parts;

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

std::string transparent(Colour colour) { return fmt::format("#90{}", hex(colour).substr(1)); }

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
  figure.set_over_x();
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
