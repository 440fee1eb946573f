#include "evaluation/report/run_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "evaluation/report/figures.h"
#include "evaluation/report/html.h"
#include "evaluation/scoring/clutter.h"

namespace saccade {
namespace {

std::string share_row(std::string_view what,
                      const std::vector<std::pair<std::string, std::optional<double>>>& shares) {
  std::string html = fmt::format("<tr><th>{}</th>", what);
  for (const auto& [name, share] : shares) html += fmt::format("<th>{}</th>{}", escaped(name), cell(share));
  return html + "</tr>\n";
}

}  // namespace

std::string detector_mark(const Metrics& metrics, std::size_t index) {
  return colour_mark(detector_colour(metrics.detectors[index].first), metrics.detectors[index].first);
}

std::string detector_table(const Metrics& metrics) {
  std::string html =
      "<div class=\"wide\"><table id=\"detectors\"><thead><tr><th rowspan=\"2\">detector</th><th "
      "colspan=\"2\">average precision</th><th rowspan=\"2\">ready<br>after, ms</th><th colspan=\"3\">at the "
      "threshold</th><th "
      "colspan=\"2\">inliers per s</th><th colspan=\"2\">position error, px</th><th colspan=\"2\">radius "
      "error, px</th><th rowspan=\"2\">lag<br>ms</th><th rowspan=\"2\">µs "
      "per<br>event</th></tr><tr><th>by "
      "event<br>time</th><th>streaming</th><th>threshold</th><th>precision</th><th>recall</th><th>mean</"
      "th><th>peak</"
      "th><th>median</th><th>95 %</th><th>median</th><th>95 %</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < metrics.detectors.size(); ++i) {
    const auto& [name, s] = metrics.detectors[i];
    html +=
        fmt::format("<tr><th>{}{}</th>", detector_mark(metrics, i),
                    metrics.gaze && metrics.gaze->detector == name ? " <small>drives the gaze</small>" : "");
    const StreamingScore streaming = s.streaming.value_or(StreamingScore{});
    html += cell(s.average_precision) + cell(streaming.average_precision) +
            cell(streaming.latency_median_ms) + cell(s.threshold) + cell(s.precision) + cell(s.recall) +
            cell(s.mean_rate_hz) + cell(s.peak_rate_hz) + cell(s.position_error_px.median) +
            cell(s.position_error_px.p95) + cell(s.radius_error_px.median) + cell(s.radius_error_px.p95) +
            cell(s.lag_ms) + cell(s.us_per_event) + "</tr>\n";
  }
  const std::optional<double> share = dropped_share(metrics);
  return html +
         "</tbody></table></div>\n<p class=\"facts\">By event time a detector is judged at the instants of "
         "its "
         "events, however late they came. Streaming: at each instant the newest estimate that a robot could "
         "use "
         "then; ready after: from the instant that an estimate is about until then, median. All other "
         "columns "
         "are by event time." +
         (share ? fmt::format(" The event camera dropped {:.2g} % of its events.", 100.0 * *share) : "") +
         "</p>\n";
}

std::string gaze_line(const GazeMetrics& gaze) {
  std::string html = "<p class=\"facts\">driven by " + escaped(gaze.detector);
  if (!gaze.window.empty()) html += " · window: " + escaped(gaze.window);
  if (!gaze.gate.empty()) html += " · gate: " + escaped(gaze.gate);
  if (!gaze.controller.empty()) html += " · controller: " + escaped(gaze.controller);
  return html + "</p>\n";
}

std::string gaze_table(const GazeMetrics& gaze, double duration_s) {
  const GazeScore& s = gaze.score;
  const auto row = [](std::string_view what, const std::string& value) {
    return fmt::format("<tr><th>{}</th>{}</tr>\n", what, value);
  };
  return "<table id=\"gaze\"><tbody>\n" +
         row(fmt::format("acquired (within {:.3g}°) after, s", s.acquire_within_deg), cell(s.acquire_s)) +
         row("fixation error, median, deg", cell(s.fixation_error_deg.median)) +
         row("fixation error, 95 %, deg", cell(s.fixation_error_deg.p95)) +
         row("on target (below 2°), share of the time", cell(s.on_target_ratio)) +
         row("in view, share of the time", cell(s.in_view_ratio)) +
         row("detected while following, per s", cell(gaze.following_rate_hz)) +
         row("target off the ball, median, mm", cell(s.target_error_median_m, 1e3)) +
         row("moves", count_cell(s.moves)) + row("wrong moves", count_cell(s.wrong_moves)) +
         row("saccades", count_cell(s.saccades)) +
         row("saccades per s",
             cell(duration_s > 0.0 ? std::optional(static_cast<double>(s.saccades) / duration_s)
                                   : std::nullopt)) +
         row("joint limit violations", count_cell(s.limit_violations)) + "</tbody></table>\n";
}

std::string clutter_tables(const Metrics& m) {
  if (!m.clutter) return {};
  std::string html = "<h2>Clutter</h2>\n<div class=\"wide\"><table id=\"clutter\"><tbody>\n" +
                     share_row("share of the events, by object", m.clutter->by_object) +
                     share_row("by cause", m.clutter->by_cause) + "</tbody></table></div>\n";
  html += fmt::format(
      "<div class=\"wide\"><table id=\"clutter_by_detector\"><thead><tr><th rowspan=\"2\">detector</th><th "
      "colspan=\"2\">clutter among the newest {} events</th><th rowspan=\"2\">clutter events<br>per "
      "inlier</th></tr><tr><th>where it detected</th><th>where it did not</th></tr></thead><tbody>\n",
      ClutterCounter::window_events);
  for (std::size_t i = 0; i < m.detectors.size(); ++i) {
    const DetectorClutter clutter = m.detectors[i].second.clutter.value_or(DetectorClutter{});
    html += fmt::format("<tr><th>{}</th>", detector_mark(m, i)) + cell(clutter.in_window_detected) +
            cell(clutter.in_window_missed) + cell(clutter.per_detection) + "</tr>\n";
  }
  return html +
         "</tbody></table></div>\n<p class=\"facts\">Clutter is every event that the ball did not make. "
         "Where it did not: chances without an observation at or above the threshold.</p>\n";
}

std::string rejected_remark(const Metrics& m) {
  std::string html;
  const std::string& controller = m.gaze ? m.gaze->failure : m.controller_failure;
  if (!controller.empty()) {
    html += fmt::format(
        "<p class=\"remark\">The gaze controller ended before the end of the run, and the head stayed where "
        "it was: "
        "{}.</p>\n",
        escaped(controller));
  }
  for (const auto& [name, score] : m.detectors) {
    const RejectedEvents rejected = score.rejected_events.value_or(RejectedEvents{});
    if (!score.failure.empty()) {
      html += fmt::format(
          "<p class=\"remark\">{} ended before the end of the run, and has no detections from then on: "
          "{}.</p>\n",
          escaped(name), escaped(score.failure));
    }
    if (rejected.outside_image + rejected.back_in_time == 0) continue;
    html += fmt::format(
        "<p class=\"remark\">{} dropped {} events outside the image and {} whose time goes back.</p>\n",
        escaped(name), rejected.outside_image, rejected.back_in_time);
  }
  return html;
}

std::string interrupted_remark(const Metrics& m) {
  if (!m.interrupted) return {};
  return fmt::format(
      "<p class=\"remark\" id=\"interrupted\">This run was interrupted after {:.3g} s. All figures are of "
      "what "
      "was processed until then.</p>\n",
      m.duration_s);
}

std::string approximate_remark(const Metrics& m) {
  const bool exact = (!m.gaze || m.gaze->score.exact) &&
                     std::all_of(m.detectors.begin(), m.detectors.end(),
                                 [](const auto& detector) { return detector.second.exact; });
  if (exact) return {};
  return "<p class=\"remark\">This run is so long that its percentiles, lags and precision-recall curves are "
         "approximate (0.1 %; docs/run_folder.md); counts, ratios and rates are exact.</p>\n";
}

}  // namespace saccade
