#include "evaluation/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "evaluation/report/eye_movement_section.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/gaze_figures.h"
#include "evaluation/report/gnuplot_process.h"
#include "evaluation/report/html.h"
#include "evaluation/report/run_data.h"
#include "evaluation/report/run_head.h"
#include "evaluation/report/run_images.h"
#include "evaluation/report/run_tables.h"
#include "evaluation/scoring/ball_speed.h"
#include "evaluation/scoring/eye_movement.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t enough_saccades = 3;  // for a figure

FigureFolder out_of(const RunData& run) { return {run.folder, run.paper}; }

std::string detection_figures(const RunData& run) {
  const Metrics& m = run.metrics;
  std::string html;
  const bool scored = std::any_of(m.detectors.begin(), m.detectors.end(),
                                  [](const auto& d) { return !d.second.pr_curve.empty(); });
  for (const auto& [name, score] : m.detectors) {
    html += figure_html(
        name + (run.truth.empty() ? ": circles over time" : " against truth"),
        run.truth.empty() ? "Every dot is an observation above the threshold; a ball makes a smooth trace, "
                            "clutter makes scattered dots."
                          : "Dots are observations above the threshold; those on the line of the truth in "
                            "all three panels are right, gaps are times without an observation.",
        tracking_figure("track_" + file_part(name), run.truth, run.detections, name, score.threshold,
                        detector_colour(name), run.sparse_truth(), m.start_us),
        out_of(run));
  }
  if (scored) {
    html += figure_html(
        "Precision and recall",
        "Each curve runs through all thresholds; the further up and right, the better. The square "
        "is the threshold in use.",
        precision_recall_figure("precision_recall", m), out_of(run));
  }
  return html;
}

std::string rate_figures(const RunData& run) {
  const Metrics& m = run.metrics;
  const EventCounts* events = run.event_counts ? &*run.event_counts : nullptr;
  if (!run.scored_every_ms()) {
    return figure_html("Events and detections per time",
                       "Events come where something moves in the image; observations above the threshold get "
                       "rare while the ball stands still in it.",
                       rates_figure("rates", events, {}, {}, run.detections, m, m.start_us), out_of(run));
  }
  std::string html = figure_html(
      "Detection rate over time",
      "How often per second each detector is right, in bins of 100 ms, between the rate of events and the "
      "speed of the ball in the image. Events come where something moves: an event-driven detector is fast "
      "while the ball moves and may find nothing while it stands still; a frame camera gives 30 images "
      "per second at best. Gaps are times without a visible ball.",
      rates_figure("rates", events, run.truth, run.found, run.detections, m, m.start_us), out_of(run));
  const std::vector<double> speed_px_s = image_speed_px_s(run.truth);
  std::vector<DetectorSpeeds> speeds;
  for (std::size_t i = 0; i < m.detectors.size(); ++i) {
    speeds.push_back({{m.detectors[i].first, detector_colour(m.detectors[i].first)}, {}});
    speeds.back().counts.add(run.found[i], speed_px_s);
  }
  // None where no ball was visible for long enough.
  const bool any_rate = std::ranges::any_of(speeds, [](const DetectorSpeeds& detector) {
    const auto& counts = detector.counts;
    for (std::size_t bin = 0; bin < SpeedCounts::bounds_px_s.size(); ++bin) {
      if (counts.rate_hz(bin)) return true;
    }
    return false;
  });
  if (!any_rate) return html;
  return html +
         figure_html("Detection rate over the ball's speed",
                     "The same, sorted by the speed of the ball in the image. 1000 per second is a ball "
                     "found at every millisecond; speeds seen for less than 50 ms are left out.",
                     rate_over_speed_figure("rate_over_speed", speeds), out_of(run));
}

std::string gaze_figures(const RunData& run) {
  const Metrics& m = run.metrics;
  std::string html;
  if (!m.gaze || run.gaze.empty()) return html;
  const GazeTables tables{.truth = run.truth, .gaze = run.gaze, .eye = run.eye};
  html += shifts_figure(run);
  if (!run.eye.empty()) {
    html += figure_html(
        "Gaze over time",
        "Above: the angle between the left eye's optical axis and the ball (low is good), and the times of "
        "the gaze "
        "targets; errors before acquisition may lie outside the axes. Below: the eye's angular speed. Bands "
        "are "
        "saccades, faster than 60°/s for 10 ms or more: a gaze that follows in steps has many, with an error "
        "that "
        "rises between them.",
        gaze_over_time_figure("gaze_over_time", tables, m.camera, m.gaze->score.acquired_at_us, m.start_us),
        out_of(run));
  }
  const std::vector<Saccade> saccades = saccades_of(run.eye);
  if (saccades.size() >= enough_saccades) {
    html += figure_html(
        "Saccades",
        "Each saccade's peak speed over its size (main sequence). The CSV file has the start times.",
        main_sequence_figure("saccades", saccades, m.start_us), out_of(run));
  }
  html += figure_html(
      "Gaze in the robot's frame",
      "Left: the plane in front of the robot as the robot sees it; right: the side view from its "
      "right. Where the gaze follows well its line lies on the ball's path; the dots are the gaze "
      "targets. Points far from the ball lie outside.",
      gaze_paths_figure("gaze_paths", std::vector<GazePath>{{"", tables, m.start_us}}), out_of(run));
  html += figure_html(
      "Joints and their limits",
      "Line: joint angle; dashed: limits. Where the line runs along a limit the head cannot turn further.",
      joints_figure("joints", run.gaze, m.gaze->limits, m.start_us), out_of(run));
  return html;
}

std::string body(const RunData& run) {
  const Metrics& m = run.metrics;
  std::string html = run_head(run) + interrupted_remark(m) + approximate_remark(m);
  if (!run.events_remark.empty()) {
    html += fmt::format("<p class=\"remark\">Events are not shown: {}</p>\n", escaped(run.events_remark));
  }
  if (fs::exists(run.folder / run_file::replay))
    html += "<p><a href=\"replay.html\">Replay of the run</a></p>\n";
  if (fs::exists(run.folder / "video.mp4")) html += "<p><a href=\"video.mp4\">Video of the run</a></p>\n";
  html += frames_figure(run);
  if (m.gaze)
    html += "<h2>Gaze</h2>\n" + gaze_line(*m.gaze) + gaze_table(*m.gaze, m.duration_s) + gaze_figures(run);
  html += eye_movement_section(run);
  html += "<h2>Detection</h2>\n" + detector_table(m);
  html +=
      "<p class=\"facts\">An observation is right within 6 px of the true centre and 2 px of the true "
      "radius. – means that the figure does not apply.</p>\n";
  html += rejected_remark(m) + hough_figure(run) + detection_figures(run);
  if (run.event_counts || run.scored_every_ms()) html += rate_figures(run);
  html += clutter_tables(m);
  return html;
}

}  // namespace

std::string undrawn_warning() {
  if (gnuplot_installed()) return {};
  return "the figures of the page are not drawn: gnuplot is not installed (Debian package gnuplot-nox); "
         "saccade report "
         "draws them later";
}

void write_report(const fs::path& run_folder, const FormatRegistry& formats, const fs::path& figures) {
  RunData run = load_run(run_folder, formats);
  run.paper = figures;
  write_page(run_folder, run.metrics.scenario, body(run));
}

}  // namespace saccade
