#include "evaluation/report/eye_movement_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

#include "evaluation/report/figure_parts.h"
#include "evaluation/report/palette.h"

namespace saccade {

using namespace figure_parts;

namespace {

using ScoreValue = std::function<std::optional<double>(const EyeMovementScore&)>;

struct FigureRow {
  const char* name;
  ScoreValue value;
};

std::optional<double> median_latency_ms(const EyeMovementScore& score) {
  std::vector<double> latencies;
  for (const GazeStep& step : score.steps) {
    if (step.latency_ms) latencies.push_back(*step.latency_ms);
  }
  return quantile(latencies, 0.5);
}

template <class Part, class Member>
ScoreValue part_value(std::optional<Part> EyeMovementScore::*which, Member Part::*member) {
  return [=](const EyeMovementScore& score) -> std::optional<double> {
    const std::optional<Part>& found = score.*which;
    return found ? std::optional(static_cast<double>((*found).*member)) : std::nullopt;
  };
}

const std::vector<FigureRow>& figure_rows() {
  using Score = EyeMovementScore;
  static const std::vector<FigureRow> all = {
      {"pursuit: frequency, Hz", part_value(&Score::pursuit, &Transfer::frequency_hz)},
      {"pursuit: gain", part_value(&Score::pursuit, &Transfer::gain)},
      {"pursuit: phase, deg", part_value(&Score::pursuit, &Transfer::phase_deg)},
      {"pursuit: lag, ms", [](const Score& s) { return s.pursuit_lag_ms; }},
      {"sway: frequency, Hz", part_value(&Score::stabilisation, &Transfer::frequency_hz)},
      {"sway: gain of the counter-rotation", part_value(&Score::stabilisation, &Transfer::gain)},
      {"sway: its phase, deg", part_value(&Score::stabilisation, &Transfer::phase_deg)},
      {"sway: slip reduction", [](const Score& s) { return s.slip_reduction; }},
      {"ramps: speed of the ball, deg/s", part_value(&Score::ramps, &GazeRamps::ball_deg_s)},
      {"ramps: gain", part_value(&Score::ramps, &GazeRamps::gain)},
      {"ramps: lag, deg", part_value(&Score::ramps, &GazeRamps::lag_deg)},
      {"steps: latency, median, ms", median_latency_ms},
      {"main sequence: slope, 1/s", [](const Score& s) { return s.main_sequence_per_s; }},
      {"main sequence: offset, deg/s", [](const Score& s) { return s.main_sequence_offset_deg_s; }},
      {"gaze error, median, deg", [](const Score& s) { return s.error_deg.median; }},
      {"gaze error, 95 %, deg", [](const Score& s) { return s.error_deg.p95; }},
      {"motion of the ball's image, median, px/s", [](const Score& s) { return s.image_median_px_s; }},
      {"motion of the ball's image, 90 %, px/s", [](const Score& s) { return s.image_p90_px_s; }},
  };
  return all;
}

std::string steps_table(const EyeMovementScore& score) {
  if (score.steps.empty()) return {};
  std::string html =
      "<div class=\"wide\"><table id=\"gaze_steps\"><thead><tr><th>size of the step, deg</th><th>latency, "
      "ms</th><th>peak speed, deg/s</th><th>within 1° after, ms</th></tr></thead><tbody>\n";
  for (const GazeStep& step : score.steps) {
    html += "<tr>" + cell(step.size_deg) + cell(step.latency_ms) + cell(step.peak_deg_s) +
            cell(step.settled_ms) + "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

/// Directions over time of the rows that both tables have.
Figure directions_figure(const RunData& run) {
  std::vector<Point> gaze[2];
  std::vector<Point> ball[2];
  auto truth = run.truth.begin();
  for (const EyeRow& eye : run.eye) {
    while (truth != run.truth.end() && truth->t_us < eye.t_us) ++truth;
    if (truth == run.truth.end()) break;
    if (truth->t_us != eye.t_us) continue;
    const double t_s = seconds(eye.t_us, run.metrics.start_us);
    const Eigen::Vector2d gaze_deg = direction_deg(eye.root_from_left_cam().linear().col(2));
    const Eigen::Vector2d ball_deg = direction_deg(truth->position_m - eye.position_m);
    for (int i = 0; i < 2; ++i) {
      gaze[i].push_back({t_s, gaze_deg[i]});
      ball[i].push_back({t_s, ball_deg[i]});
    }
  }
  GnuplotFigure figure("eye_directions", width, 430);
  figure.set_over_x();
  for (int i = 0; i < 2; ++i) {
    figure.add_panel(
        {.x_label = std::string(time_label),
         .y_label = i == 0 ? "right [deg]" : "up [deg]",
         .z_label = "",
         .commands = (i == 0 ? "set key horizontal outside top right width -3 maxrows 1\n" : "unset key\n") +
                     axes(i == 1),
         .series = {{.title = "ball", .style = line_style(truth_colour, 2.4), .points = std::move(ball[i])},
                    {.title = "gaze", .style = line_style(gaze_colour, 1.4), .points = std::move(gaze[i])}}});
  }
  return figure.draw("set multiplot layout 2,1 margins 0.095,0.985,0.13,0.915 spacing 0.0,0.04\n");
}

Figure slip_figure(const RunData& run) {
  std::vector<std::int64_t> t_us;
  std::vector<Eigen::Vector2d> image_px;
  for (const TruthRow& row : run.truth) {
    t_us.push_back(row.t_us);
    image_px.emplace_back(row.circle.x_px, row.circle.y_px);
  }
  const SlipHistogram histogram =
      slip_histogram(image_speeds_px_s(t_us, image_px, run.metrics.start_us + eye_movements_settled_us));
  std::vector<Point> points;
  for (std::size_t i = 0; i < histogram.shares.size(); ++i) {
    for (const std::size_t edge : {i, i + 1})
      points.push_back({SlipHistogram::width_px_s * static_cast<double>(edge), 100.0 * histogram.shares[i]});
  }
  GnuplotFigure figure("image_motion", width, 300);
  figure.set_over_x();
  figure.add_panel(
      {.x_label = "motion of the ball's image [px/s]",
       .y_label = "share of the time [%]",
       .z_label = "",
       .commands = "unset key\nset offsets 0, 0, graph 0.1, 0\nset yrange [0:*]\n",
       .series = {{.title = "image motion", .style = line_style(gaze_colour, 1.6), .points = points}}});
  return figure.draw();
}

using TransferOf = std::optional<Transfer> EyeMovementScore::*;

std::string bode_figure(const char* name, const char* title, std::span<const EyeMovementColumn> columns,
                        TransferOf which, const FigureFolder& folder) {
  std::map<std::string, std::map<double, const Transfer*>> curves;
  for (const EyeMovementColumn& column : columns) {
    if (const auto& transfer = column.score->*which)
      curves[column.label][transfer->frequency_hz] = &*transfer;
  }
  std::erase_if(curves, [](const auto& curve) { return curve.second.size() < 2; });
  if (curves.empty()) return {};
  std::vector<std::string> labels;
  for (const auto& curve : curves) labels.push_back(curve.first);
  GnuplotFigure figure(name, width, 430);
  figure.set_over_x();
  for (const bool gain : {true, false}) {
    std::vector<Series> series;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      std::vector<Point> points;
      for (const auto& [hz, transfer] : curves[labels[i]])
        points.push_back({hz, gain ? transfer->gain : transfer->phase_deg});
      series.push_back({.title = labels[i],
                        .style = line_style(detector_colour(labels[i]), 1.6),
                        .points = std::move(points)});
    }
    figure.add_panel({.x_label = "frequency [Hz]",
                      .y_label = gain ? "gain" : "phase [deg]",
                      .z_label = "",
                      .commands = (gain ? "set key outside top right\n" : "unset key\n") +
                                  axes(!gain, gain ? "[0:*]" : "[*:*]") + "set logscale x\n",
                      .series = std::move(series)});
  }
  return figure_html(title, "Above: gain, 1 is exact. Below: phase, negative is late.",
                     figure.draw("set multiplot layout 2,1 margins 0.095,0.80,0.13,0.97 spacing 0.0,0.04\n"),
                     folder);
}

}  // namespace

std::string eye_movement_table(std::span<const EyeMovementColumn> columns) {
  std::string html = "<div class=\"wide\"><table id=\"eye_movements\">";
  if (columns.size() > 1) {
    html += "<thead><tr><th></th>";
    for (const EyeMovementColumn& column : columns) html += "<th>" + escaped(column.label) + "</th>";
    html += "</tr></thead>";
  }
  html += "<tbody>\n";
  for (const FigureRow& row : figure_rows()) {
    const bool any = std::ranges::any_of(
        columns, [&](const auto& column) { return row.value(*column.score).has_value(); });
    if (!any) continue;
    html += fmt::format("<tr><th>{}</th>", row.name);
    for (const EyeMovementColumn& column : columns) html += cell(row.value(*column.score));
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string bode_figures(std::span<const EyeMovementColumn> columns, const FigureFolder& folder) {
  return bode_figure("bode_pursuit", "Pursuit over frequency", columns, &EyeMovementScore::pursuit, folder) +
         bode_figure("bode_stabilisation", "Stabilisation over frequency", columns,
                     &EyeMovementScore::stabilisation, folder);
}

std::string eye_movement_section(const RunData& run) {
  const Metrics& m = run.metrics;
  if (!m.gaze || !m.gaze->eye_movements) return {};
  const EyeMovementScore& score = *m.gaze->eye_movements;
  const FigureFolder folder{run.folder, run.paper};
  const EyeMovementColumn column{"", &score};
  std::string html = "<h2>Eye movements</h2>\n" + eye_movement_table({&column, 1}) + steps_table(score) +
                     "<p class=\"facts\">Figures from 3 s on, steps from 1 s on; docs/oculomotor.md defines "
                     "them.</p>\n";
  if (run.eye.empty() || run.truth.empty()) return html;
  html += figure_html("Directions of ball and gaze",
                      "In the robot's frame, from the left eye. A gaze that follows lies on the ball's line.",
                      directions_figure(run), folder);
  html += figure_html(
      "Motion of the ball's image",
      "Retinal slip from 3 s on: how fast the ball moves in the left eye's image, over 10 ms. The last "
      "bin holds all faster motion.",
      slip_figure(run), folder);
  return html;
}

}  // namespace saccade
