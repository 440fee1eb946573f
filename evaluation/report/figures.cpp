#include "evaluation/report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "evaluation/report/figure_parts.h"

namespace saccade {

using namespace figure_parts;

Figure tracking_figure(std::string_view name, std::span<const TruthRow> truth,
                       std::span<const DetectionRow> detections, std::string_view detector, double threshold,
                       Colour colour, bool sparse, std::int64_t start_us) {
  std::vector<DetectionRow> accepted;
  std::copy_if(detections.begin(), detections.end(), std::back_inserter(accepted),
               [&](const DetectionRow& d) { return d.detector == detector && d.score >= threshold; });
  struct Quantity {
    const char* label;
    double Circle::*member;
  };
  GnuplotFigure figure(name, width, 520);
  figure.set_over_x();
  for (const Quantity& q :
       {Quantity{"x [px]", &Circle::x_px}, {"y [px]", &Circle::y_px}, {"r [px]", &Circle::r_px}}) {
    const bool last = q.member == &Circle::r_px;
    const auto circle_value = [&](const auto& row) { return row.circle.*q.member; };
    const auto truth_value = [&](const TruthRow& row) {
      return row.visible >= chance_visible_share ? circle_value(row) : nan;
    };
    double end_s = 0.0;
    if (!truth.empty()) end_s = seconds(truth.back().t_us, start_us);
    if (!detections.empty()) end_s = std::max(end_s, seconds(detections.back().t_us, start_us));
    const bool first = q.member == &Circle::x_px;
    std::vector<Series> series = {{.title = std::string(detector),
                                   .style = dot_style(colour),
                                   .points = over_time(accepted, start_us, circle_value)}};
    if (!truth.empty()) {
      series.push_back({.title = "truth",
                        .style = sparse
                                     ? fmt::format("points pt 6 ps 0.6 lw 1.5 lc rgb '{}'", hex(truth_colour))
                                     : line_style(truth_colour, 1.4),
                        .points = over_time(truth, start_us, truth_value)});
    }
    figure.add_panel({.x_label = std::string(time_label),
                      .y_label = q.label,
                      .z_label = "",
                      .commands = axes(last) + time_range(0.0, end_s) +
                                  (first ? "set key horizontal outside top right\n" : "unset key\n"),
                      .series = std::move(series)});
  }
  return figure.draw(stacked(3));
}

Figure precision_recall_figure(std::string_view name, const Metrics& metrics) {
  std::vector<Series> series;
  for (const auto& [detector, score] : metrics.detectors) {
    const Colour colour = detector_colour(detector);
    series.push_back({.title = detector, .style = line_style(colour, 2.0), .points = curve_points(score)});
    if (score.recall && score.precision) {
      series.push_back({.title = detector + ", its threshold",
                        .style = square_style(colour),
                        .points = {{*score.recall, *score.precision, score.threshold}},
                        .in_key = false});
    }
  }
  GnuplotFigure figure(name, width, 420);
  figure.set_over_x();
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

/// The highest rate of a 30 Hz camera, where no detector is one.
void add_frame_camera(std::vector<Series>& series, bool simulated, double from, double to) {
  if (simulated) return;
  series.push_back({.title = "30 Hz frames at best",
                    .style = fmt::format("lines lw 1.6 dt 2 lc rgb '{}'", hex(detector_colour(frame_camera))),
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
                     .style = line_style(detector_colour(detector)),
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
                                  .style = line_style(neutral_colour, 1.2),
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
         .series = {{.title = "ball", .style = line_style(truth_colour, 1.6), .points = std::move(speed)}}});
  }
  const std::size_t rates_panel = with_events ? 1 : 0;
  GnuplotFigure figure(name, width, height);
  figure.set_over_x();
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
                      .style = fmt::format("linespoints pt 7 ps 0.5 lw 2 lc rgb '{}'", hex(detector.colour)),
                      .points = std::move(points)});
  }
  const double slowest = bounds[1] / bin_ratio;
  add_frame_camera(series, frames, slowest, fastest);
  GnuplotFigure figure(name, width, 340);
  figure.set_over_x();
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

}  // namespace saccade
