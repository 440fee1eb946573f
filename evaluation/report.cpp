#include "evaluation/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/config.h"
#include "core/error.h"
#include "evaluation/figures.h"
#include "evaluation/metrics.h"
#include "evaluation/overlay.h"
#include "recording/event_file.h"
#include "recording/output_file.h"
#include "recording/run_files.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_strip_frames = 12;
constexpr std::size_t strip_frames_without_pictures = 8;
constexpr std::int64_t picture_window_us = 10'000;
constexpr double events_per_picture = 1'500.0;  // where there are no saved pictures, as the paper's window
constexpr int eye_picture_px = 384;
constexpr int scene_picture_px = 512;
constexpr double deg_per_rad = 180.0 / std::numbers::pi;

/// One picture of the strip.
struct Frame {
  std::int64_t t_us = 0;
  fs::path eye;  ///< empty where the run saved none
  fs::path scene;
  std::vector<Event> events;
};

struct Run {
  fs::path folder;
  Metrics metrics;
  std::vector<TruthRow> truth;
  std::vector<DetectionRow> detections;
  std::vector<GazeRow> gaze;
  std::vector<Frame> frames;
  bool has_pictures = false;
  std::int64_t window_us = picture_window_us;
  std::optional<EventCounts> event_counts;
  std::string events_remark;  ///< why events are not shown

  /// A recording's annotations, not one row per millisecond: then nothing is known of the ball's place in the
  /// world.
  [[nodiscard]] bool sparse_truth() const {
    return !truth.empty() && !std::isfinite(truth.front().position_m.x());
  }
};

template <class Row>
std::vector<Row> read_if_there(const fs::path& path) {
  return fs::exists(path) ? read_table<Row>(path) : std::vector<Row>{};
}

template <class T>
std::vector<T> spread_out(const std::vector<T>& all, std::size_t count) {
  if (all.size() <= count) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * (all.size() - 1) / (count - 1)]);
  return some;
}

/// Pictures saved as <t_us>_eye.png and <t_us>_scene.png.
std::vector<Frame> saved_frames(const fs::path& folder) {
  std::map<std::int64_t, Frame> frames;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      std::int64_t t_us = 0;
      const auto number = std::from_chars(name.data(), name.data() + name.size(), t_us);
      const std::string_view kind(number.ptr, name.data() + name.size());
      if (number.ec != std::errc{} || (kind != "_eye.png" && kind != "_scene.png")) continue;
      frames[t_us].t_us = t_us;
      (kind == "_eye.png" ? frames[t_us].eye : frames[t_us].scene) = entry.path();
    }
  }
  std::vector<Frame> sorted;
  for (auto& [t_us, frame] : frames) sorted.push_back(std::move(frame));
  return spread_out(sorted, max_strip_frames);
}

std::vector<Frame> frames_without_pictures(const Run& run) {
  std::vector<Frame> frames;
  for (const TruthRow& row : run.truth) {
    if (row.visible >= chance_visible_share)
      frames.push_back({.t_us = row.t_us, .eye = {}, .scene = {}, .events = {}});
  }
  if (frames.empty()) {
    const auto end_us = static_cast<std::int64_t>(run.metrics.duration_s * 1e6);
    const std::int64_t step_us = end_us / (static_cast<std::int64_t>(strip_frames_without_pictures) + 1);
    for (std::int64_t t_us = step_us; step_us > 0 && t_us < end_us; t_us += step_us) {
      frames.push_back({.t_us = run.metrics.start_us + t_us, .eye = {}, .scene = {}, .events = {}});
    }
  }
  return spread_out(frames, strip_frames_without_pictures);
}

/// One pass over the recording: counts over time, and the events just before each frame.
void read_events(Run& run) {
  const Metrics& metrics = run.metrics;
  if (metrics.events_file.empty()) return;
  EventCounts counts;
  counts.start_us = metrics.start_us;
  counts.bin_us =
      std::max<std::int64_t>(1'000, static_cast<std::int64_t>(metrics.duration_s * 1e6 / 1'000.0));
  counts.counts.resize(
      static_cast<std::size_t>(metrics.duration_s * 1e6 / static_cast<double>(counts.bin_us)) + 1);
  const auto take = [&](const Event& event) {
    if (event.camera != 0) return;
    const std::int64_t bin = (event.t_us - counts.start_us) / counts.bin_us;
    if (event.t_us >= counts.start_us && bin < std::ssize(counts.counts))
      ++counts.counts[static_cast<std::size_t>(bin)];
    const auto later = [](const Frame& frame, std::int64_t t_us) { return frame.t_us < t_us; };
    for (auto frame = std::lower_bound(run.frames.begin(), run.frames.end(), event.t_us, later);
         frame != run.frames.end() && frame->t_us - run.window_us < event.t_us; ++frame) {
      frame->events.push_back(event);
    }
  };
  try {
    const auto reader = open_event_file(run.folder / metrics.events_file);
    std::vector<Event> block;
    while (reader->read(block, 65'536) > 0) {
      std::for_each(block.begin(), block.end(), take);
      block.clear();
    }
    run.event_counts = std::move(counts);
  } catch (const InputError& error) {
    run.events_remark = error.what();
  }
}

Run load(const fs::path& folder) {
  Run run;
  run.folder = folder;
  run.metrics = read_metrics(folder / "metrics.json");
  run.truth = read_if_there<TruthRow>(folder / "truth.csv");
  run.detections = read_if_there<DetectionRow>(folder / "detections.csv");
  run.gaze = read_if_there<GazeRow>(folder / "gaze.csv");
  run.frames = saved_frames(folder / "frames");
  run.has_pictures = !run.frames.empty();
  if (!run.has_pictures) {
    run.frames = frames_without_pictures(run);
    const double mean_us = run.metrics.duration_s * 1e6 * events_per_picture /
                           static_cast<double>(std::max<std::int64_t>(1, run.metrics.event_count));
    run.window_us = 1'000 * std::llround(std::clamp(mean_us, 1e3, 2e5) * 1e-3);
  }
  read_events(run);
  return run;
}

// ---- HTML
// -------------------------------------------------------------------------------------------

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

std::string picture_html(const cv::Mat& picture, const char* format, const std::string& alt) {
  std::vector<unsigned char> bytes;
  cv::imencode(std::string(".") + format, picture, bytes,
               std::string_view(format) == "png" ? std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 9}
                                                 : std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 85});
  return fmt::format("<img alt=\"{}\" width=\"{}\" height=\"{}\" src=\"data:image/{};base64,{}\">",
                     escaped(alt), picture.cols, picture.rows, format, base64(bytes));
}

/// Inside a page an SVG needs no namespaces, and the page then holds no address at all.
std::string inline_svg(std::string svg) {
  for (std::size_t at = 0; (at = svg.find("xmlns")) != std::string::npos;) {
    svg.erase(at, svg.find('"', svg.find('"', at) + 1) + 1 - at);
  }
  return svg;
}

/// Full precision for machines, three figures for people.
std::string cell(const std::optional<double>& value, double factor = 1.0) {
  if (!value) return "<td class=\"none\">–</td>";
  const double shown = *value * factor;
  const std::string text =
      std::abs(shown) >= 100.0 ? fmt::format("{:.0f}", shown) : fmt::format("{:.3g}", shown);
  return fmt::format("<td data-value=\"{}\">{}</td>", text_of(*value), text);
}

std::string count_cell(std::int64_t value) { return fmt::format("<td data-value=\"{0}\">{0}</td>", value); }

/// The detector's name with its colour.
std::string detector_mark(const Metrics& metrics, std::size_t index) {
  return fmt::format("<span class=\"dot\" style=\"background:{}\"></span>{}", detector_colour(index),
                     escaped(metrics.detectors[index].first));
}

std::string detector_table(const Metrics& metrics) {
  std::string html =
      "<div class=\"wide\"><table id=\"detectors\"><thead><tr><th rowspan=\"2\">detector</th><th "
      "rowspan=\"2\">average<br>precision</th><th colspan=\"3\">at the threshold</th><th "
      "colspan=\"2\">inliers per s</th><th colspan=\"2\">position error, px</th><th colspan=\"2\">radius "
      "error, px</th><th rowspan=\"2\">lag<br>ms</th><th rowspan=\"2\">µs "
      "per<br>event</th></tr><tr><th>threshold</th><th>precision</th><th>recall</th><th>mean</th><th>peak</"
      "th><th>median</th><th>95 %</th><th>median</th><th>95 %</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < metrics.detectors.size(); ++i) {
    const auto& [name, s] = metrics.detectors[i];
    html +=
        fmt::format("<tr><th>{}{}</th>", detector_mark(metrics, i),
                    metrics.gaze && metrics.gaze->detector == name ? " <small>drives the gaze</small>" : "");
    html += cell(s.average_precision) + cell(s.threshold) + cell(s.precision) + cell(s.recall) +
            cell(s.mean_rate_hz) + cell(s.peak_rate_hz) + cell(s.position_error_px.median) +
            cell(s.position_error_px.p95) + cell(s.radius_error_px.median) + cell(s.radius_error_px.p95) +
            cell(s.lag_ms) + cell(s.us_per_event) + "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string gaze_table(const GazeScore& s) {
  const auto row = [](std::string_view what, const std::string& value) {
    return fmt::format("<tr><th>{}</th>{}</tr>\n", what, value);
  };
  return "<table id=\"gaze\"><tbody>\n" +
         row(fmt::format("acquired (within {:.3g}°) after, s", s.acquire_within_deg), cell(s.acquire_s)) +
         row("fixation error, median, deg", cell(s.fixation_error_deg.median)) +
         row("fixation error, 95 %, deg", cell(s.fixation_error_deg.p95)) +
         row("on target (below 2°), share of the time", cell(s.on_target_ratio)) +
         row("in view, share of the time", cell(s.in_view_ratio)) +
         row("target off the ball, median, mm", cell(s.target_error_median_m, 1e3)) +
         row("moves", count_cell(s.moves)) + row("wrong moves", count_cell(s.wrong_moves)) +
         row("saccades", count_cell(s.saccades)) +
         row("joint limit violations", count_cell(s.limit_violations)) + "</tbody></table>\n";
}

std::string summary(const Metrics& m) {
  std::string html = fmt::format("<p class=\"facts\">{:.3g} s", m.duration_s);
  if (m.seed) html += fmt::format(" · seed {}", *m.seed);
  html += fmt::format(" · {} events", m.event_count);
  if (m.duration_s > 0.0)
    html += fmt::format(" ({:.3g} thousand per s)", static_cast<double>(m.event_count) * 1e-3 / m.duration_s);
  if (m.wall_s && *m.wall_s > 0.0) {
    html += fmt::format(" · computed in {:.3g} s ({:.2g} × real time)", *m.wall_s, m.duration_s / *m.wall_s);
  }
  return html + "</p>\n";
}

std::string figure(std::string_view title, std::string_view reading, const std::string& content) {
  return fmt::format("<figure><h3>{}</h3>\n{}\n<figcaption>{}</figcaption></figure>\n", escaped(title),
                     content, reading);
}

template <class Rows>
auto newest(const Rows& rows, std::int64_t t_us) {
  const auto after = std::upper_bound(rows.begin(), rows.end(), t_us,
                                      [](std::int64_t t, const auto& row) { return t < row.t_us; });
  return after == rows.begin() ? rows.end() : after - 1;
}

EyePicture eye_picture(const Run& run, const Frame& frame) {
  EyePicture eye;
  eye.size = run.metrics.image;
  if (!frame.eye.empty()) {
    eye.grey = cv::imread(frame.eye.string(), cv::IMREAD_GRAYSCALE);
    if (eye.grey.cols != eye.size.width || eye.grey.rows != eye.size.height) {
      throw InputError(frame.eye.string(),
                       fmt::format("a picture of {} x {} pixels", eye.grey.cols, eye.grey.rows),
                       fmt::format("{} x {}, as the camera", eye.size.width, eye.size.height));
    }
  }
  eye.events = frame.events;
  if (const auto row = newest(run.truth, frame.t_us); row != run.truth.end() &&
                                                      frame.t_us - row->t_us < 1'000 && row->visible > 0.0 &&
                                                      std::isfinite(row->circle.x_px)) {
    eye.truth = row->circle;
  }
  for (std::size_t i = 0; i < run.metrics.detectors.size(); ++i) {
    const auto& [name, score] = run.metrics.detectors[i];
    for (auto row = newest(run.detections, frame.t_us);
         row != run.detections.end() && frame.t_us - row->t_us < run.window_us; --row) {
      if (row->detector == name && row->score >= score.threshold) {
        eye.detections.push_back({row->circle, "", detector_colour(i)});
        break;
      }
      if (row == run.detections.begin()) break;
    }
  }
  if (run.metrics.camera)
    eye.principal_px = Eigen::Vector2d(run.metrics.camera->cx_px, run.metrics.camera->cy_px);
  return eye;
}

std::string strip(const Run& run) {
  if (run.frames.empty() || run.metrics.image.pixels() <= 0) return {};
  const int scale = std::max(1, eye_picture_px / run.metrics.image.width);
  std::string html = "<div class=\"strip\">\n";
  for (const Frame& frame : run.frames) {
    const EyePicture eye = eye_picture(run, frame);
    std::string caption =
        fmt::format("{:.2f} s", static_cast<double>(frame.t_us - run.metrics.start_us) * 1e-6);
    html += "<div class=\"frame\">";
    if (!frame.scene.empty()) {
      const cv::Mat scene = cv::imread(frame.scene.string(), cv::IMREAD_COLOR);
      if (scene.empty()) throw InputError(frame.scene.string(), "no readable picture", "a PNG file");
      const int width = std::min(scene_picture_px, scene.cols);
      html += picture_html(fit_into(scene, width, width * scene.rows / scene.cols), "jpeg",
                           "the scene at " + caption);
    }
    html += picture_html(draw_eye(eye, scale), "png", "what the left eye sees at " + caption);
    if (run.metrics.gaze && run.metrics.camera && eye.truth) {
      const Eigen::Vector3d ray = run.metrics.camera->ray(eye.truth->x_px, eye.truth->y_px);
      caption += fmt::format(" · ball {:.1f}° off the axis", std::atan(ray.head<2>().norm()) * deg_per_rad);
    }
    html += "<p>" + caption + "</p></div>\n";
  }
  html += "</div>";
  std::string reading = fmt::format(
      "Events of the last {:.3g} ms: green where it got brighter, magenta where it got darker. White with a "
      "dark rim is the true circle; the coloured ones are the newest above the threshold of each detector:",
      static_cast<double>(run.window_us) * 1e-3);
  for (std::size_t i = 0; i < run.metrics.detectors.size(); ++i) {
    reading += (i == 0 ? " " : ", ") + detector_mark(run.metrics, i);
  }
  reading += run.metrics.camera ? ". The cross marks where the eye points: a ball under it is fixated." : ".";
  return figure("What happened", reading, html);
}

std::string detection_figures(const Run& run) {
  const Metrics& m = run.metrics;
  std::string html;
  const bool scored = std::any_of(m.detectors.begin(), m.detectors.end(),
                                  [](const auto& d) { return !d.second.pr_curve.empty(); });
  for (std::size_t i = 0; i < m.detectors.size(); ++i) {
    const auto& [name, score] = m.detectors[i];
    html += figure(
        name + (run.truth.empty() ? ": circles over time" : " against truth"),
        run.truth.empty() ? "Every dot is an observation above the threshold; a ball makes a smooth trace, "
                            "clutter makes scattered dots."
                          : "Dots are observations above the threshold; those that lie on the dark truth in "
                            "all three panels are right, gaps are times without an observation.",
        inline_svg(tracking_figure(fmt::format("track{}", i), run.truth, run.detections, name,
                                   score.threshold, detector_colour(i), run.sparse_truth(), m.start_us)));
  }
  if (scored) {
    html += figure("Precision and recall",
                   "Each curve runs through all thresholds; the further up and right, the better. The square "
                   "is the threshold in use.",
                   inline_svg(precision_recall_figure("pr", m)));
  }
  return html;
}

std::string gaze_figures(const Run& run) {
  const Metrics& m = run.metrics;
  std::string html;
  if (!m.gaze || run.gaze.empty()) return html;
  if (m.camera && !run.truth.empty()) {
    html += figure("Gaze in angle",
                   "How far the ball is from the left eye's optical axis: low is good, a sudden fall is a "
                   "gaze shift that caught up, and gaps are times with the ball behind the camera.",
                   inline_svg(fixation_figure("fixation", run.truth, *m.camera, m.start_us)));
  }
  html += figure("Gaze in space",
                 "Seen from behind the robot, in its root frame: a gaze that follows well lays the blue line "
                 "on the ball's grey path; orange dots are the points it was told to look at. What lies far "
                 "from the ball is outside the box.",
                 inline_svg(gaze_path_figure("path", run.truth, run.gaze)));
  html += figure(
      "Joints and their limits",
      "Blue: joint angle, dashed: limits; where the line runs along a limit the head cannot turn further.",
      inline_svg(joints_figure("joints", run.gaze, m.gaze->limits, m.start_us)));
  return html;
}

constexpr std::string_view style = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #1c1c1c; background: #fff; margin: 0 auto;
       max-width: 74rem; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .2rem; overflow-wrap: anywhere; }
h2 { font-size: 1.25rem; margin: 2.2rem 0 .5rem; }
h3 { font-size: 1.02rem; margin: 0 0 .5rem; }
.facts { color: #555; margin: .4rem 0 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .65rem; border-bottom: 1px solid #e2e2e2; text-align: right; }
thead th { font-weight: 600; color: #555; vertical-align: bottom; text-align: center; }
tbody th { text-align: left; font-weight: 500; white-space: nowrap; }
small { color: #666; }
.none { color: #999; }
.dot { display: inline-block; width: .7em; height: .7em; border-radius: 50%; margin-right: .45em; }
figure { margin: 1.2rem 0; padding: 1rem; border: 1px solid #e2e2e2; border-radius: 8px; }
figure svg { width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .9rem; margin-top: .5rem; }
.strip { display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: .8rem; }
.frame img { display: block; width: 100%; height: auto; border-radius: 4px; margin-bottom: .3rem; }
.frame p { margin: 0; font-size: .85rem; color: #555; }
.remark { color: #8a4b00; }
)";

std::string page(const Run& run) {
  const Metrics& m = run.metrics;
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, "
      "initial-scale=1\">\n<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{2}",
      escaped(m.scenario), style, summary(m));
  if (!run.events_remark.empty()) {
    html += fmt::format("<p class=\"remark\">Events are not shown: {}</p>\n", escaped(run.events_remark));
  }
  if (fs::exists(run.folder / "video.mp4")) html += "<p><a href=\"video.mp4\">The run as a film</a></p>\n";
  html += strip(run);
  if (m.gaze) html += "<h2>Gaze</h2>\n" + gaze_table(m.gaze->score) + gaze_figures(run);
  html += "<h2>Detection</h2>\n" + detector_table(m);
  html +=
      "<p class=\"facts\">An observation is right within 6 px of the true centre and 2 px of the true "
      "radius. – means that the figure does not apply.</p>\n";
  html += detection_figures(run);
  if (run.event_counts) {
    html += figure("Events and detections per time",
                   "Events come where something moves in the image; observations above the threshold get "
                   "rare when the ball stands still in it.",
                   inline_svg(rates_figure("rates", *run.event_counts, run.detections, m, m.start_us)));
  }
  return html + "</body>\n</html>\n";
}

}  // namespace

void write_report(const fs::path& run_folder) {
  OutputFile file(run_folder / "report.html");
  file.write(page(load(run_folder)));
  file.commit();
}

}  // namespace saccade
