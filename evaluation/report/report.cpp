#include "evaluation/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/gaze_figures.h"
#include "evaluation/report/html.h"
#include "evaluation/report/overlay.h"
#include "evaluation/scoring/ball_speed.h"
#include "evaluation/scoring/clutter.h"
#include "evaluation/scoring/eye_movement.h"
#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "recording/run_files.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_strip_frames = 12;
constexpr std::size_t strip_frames_without_pictures = 8;
constexpr std::size_t max_gaze_shifts = 4;
constexpr std::size_t events_per_shift = 1'500;  // of the last shift_window_us at most
constexpr std::int64_t shift_window_us = 100'000;
constexpr std::size_t enough_saccades = 3;  // to be a figure
constexpr std::int64_t picture_window_us = 10'000;
constexpr double events_per_picture = 1'500.0;  // where there are no saved pictures, as the paper's window
constexpr int eye_picture_px = 384;
constexpr int scene_picture_px = 512;
constexpr std::size_t max_hough_frames = 4;
constexpr std::size_t max_hough_detectors = 4;
constexpr int hough_picture_px = 288;
constexpr double deg_per_rad = 180.0 / std::numbers::pi;

/// A detector's Hough space at one instant.
struct SavedResponse {
  fs::path path;
  double strongest = 0.0;  ///< what white stands for
};

/// One picture of the strip.
struct Frame {
  std::int64_t t_us = 0;
  fs::path eye;  ///< empty where the run saved none
  fs::path right_eye;
  fs::path scene;
  std::map<std::size_t, SavedResponse> responses;  ///< by the detector's index in the metrics
  std::vector<Event> events;
  std::vector<Event> other_events;  ///< the other eye's, where there is one
};

struct Run {
  fs::path folder;
  Metrics metrics;
  std::vector<TruthRow> truth;
  std::vector<TruthRow> right_truth;
  std::vector<DetectionRow> detections;
  std::vector<GazeRow> gaze;
  std::vector<EyeRow> eye;
  std::vector<Frame> frames;
  std::vector<Frame> shifts;  ///< two for each of the largest gaze shifts: where it starts and where it ends
  bool has_pictures = false;
  std::int64_t window_us = picture_window_us;
  std::optional<EventCounts> event_counts;
  std::string events_remark;  ///< why events are not shown
  /// Per detector and row of truth, see found_at_chances; empty where the truth is sparse or missing.
  std::vector<std::vector<std::optional<bool>>> found;

  /// A recording's annotations, not one row per millisecond: then nothing is known of the ball's place in the
  /// world.
  [[nodiscard]] bool sparse_truth() const {
    return !truth.empty() && !std::isfinite(truth.front().position_m.x());
  }
  [[nodiscard]] bool scored_every_ms() const { return !found.empty(); }
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

/// Which detector's Hough space a picture's name after the time stands for: _<detector>_hough_<max>.png.
std::optional<std::pair<std::size_t, double>> response_in(std::string_view kind, const Metrics& metrics) {
  for (std::size_t i = 0; i < metrics.detectors.size(); ++i) {
    const std::string start = "_" + file_part(metrics.detectors[i].first) + "_hough_";
    if (!kind.starts_with(start) || !kind.ends_with(".png")) continue;
    const std::string_view text = kind.substr(start.size(), kind.size() - start.size() - 4);
    double strongest = 0.0;
    const auto number = std::from_chars(text.data(), text.data() + text.size(), strongest);
    if (number.ec == std::errc{} && number.ptr == text.data() + text.size()) return std::pair(i, strongest);
  }
  return std::nullopt;
}

/// Pictures saved as <t_us>_eye.png, <t_us>_right_eye.png, <t_us>_scene.png and <t_us>_<detector>_hough_<max>.png.
std::vector<Frame> saved_frames(const fs::path& folder, const Metrics& metrics) {
  std::map<std::int64_t, Frame> frames;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      std::int64_t t_us = 0;
      const auto number = std::from_chars(name.data(), name.data() + name.size(), t_us);
      if (number.ec != std::errc{}) continue;
      const std::string_view kind(number.ptr, name.data() + name.size());
      const auto response = response_in(kind, metrics);
      const bool eye = kind == "_eye.png";
      const bool right_eye = kind == "_right_eye.png";
      if (!eye && !right_eye && kind != "_scene.png" && !response) continue;
      Frame& frame = frames[t_us];
      frame.t_us = t_us;
      if (response) {
        frame.responses[response->first] = {entry.path(), response->second};
      } else {
        (eye ? frame.eye : right_eye ? frame.right_eye : frame.scene) = entry.path();
      }
    }
  }
  std::vector<Frame> sorted;
  for (auto& [t_us, frame] : frames) sorted.push_back(std::move(frame));
  return spread_out(sorted, max_strip_frames);
}

Frame frame_at(std::int64_t t_us) {
  return {.t_us = t_us,
          .eye = {},
          .right_eye = {},
          .scene = {},
          .responses = {},
          .events = {},
          .other_events = {}};
}

std::vector<Frame> frames_without_pictures(const Run& run) {
  std::vector<Frame> frames;
  for (const TruthRow& row : run.truth) {
    if (row.visible >= chance_visible_share) frames.push_back(frame_at(row.t_us));
  }
  if (frames.empty()) {
    const auto end_us = static_cast<std::int64_t>(run.metrics.duration_s * 1e6);
    const std::int64_t step_us = end_us / (static_cast<std::int64_t>(strip_frames_without_pictures) + 1);
    for (std::int64_t t_us = step_us; step_us > 0 && t_us < end_us; t_us += step_us) {
      frames.push_back(frame_at(run.metrics.start_us + t_us));
    }
  }
  return spread_out(frames, strip_frames_without_pictures);
}

/// The time in which a recording has as many events as the paper's window, on average.
std::int64_t usual_window_us(const Metrics& metrics) {
  const double mean_us = metrics.duration_s * 1e6 * events_per_picture /
                         static_cast<double>(std::max<std::int64_t>(1, metrics.event_count));
  return 1'000 * std::llround(std::clamp(mean_us, 1e3, 2e5) * 1e-3);
}

/// Adds an event to the frames, sorted by time, that it came at most `window_us` before; `camera` is the one that
/// they show first.
void show_event(std::vector<Frame>& frames, std::int64_t window_us, const Event& event, std::uint8_t camera) {
  const auto later = [](const Frame& frame, std::int64_t t_us) { return frame.t_us < t_us; };
  for (auto frame = std::lower_bound(frames.begin(), frames.end(), event.t_us, later);
       frame != frames.end() && frame->t_us - window_us < event.t_us; ++frame) {
    (event.camera == camera ? frame->events : frame->other_events).push_back(event);
  }
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
  const std::uint8_t camera = metrics.events_camera.value_or(0);
  const auto take = [&](const Event& event) {
    show_event(run.frames, run.window_us, event, camera);
    if (event.camera != camera) return;
    const std::int64_t bin = (event.t_us - counts.start_us) / counts.bin_us;
    if (event.t_us >= counts.start_us && bin < std::ssize(counts.counts))
      ++counts.counts[static_cast<std::size_t>(bin)];
    show_event(run.shifts, shift_window_us, event, camera);
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
  for (Frame& frame : run.shifts) {
    const auto surplus =
        std::max<std::ptrdiff_t>(0, std::ssize(frame.events) - std::ptrdiff_t{events_per_shift});
    frame.events.erase(frame.events.begin(), frame.events.begin() + surplus);
  }
}

Run load(const fs::path& folder) {
  Run run;
  run.folder = folder;
  run.metrics = read_metrics(folder / "metrics.json");
  run.truth = read_if_there<TruthRow>(folder / "truth.csv");
  run.right_truth = read_if_there<TruthRow>(folder / "truth_right.csv");
  run.detections = read_if_there<DetectionRow>(folder / "detections.csv");
  run.gaze = read_if_there<GazeRow>(folder / "gaze.csv");
  run.eye = read_if_there<EyeRow>(folder / "eye.csv");
  for (const GazeShift& shift : largest_gaze_shifts(run.gaze, run.eye, max_gaze_shifts)) {
    run.shifts.push_back(frame_at(shift.start_us));
    run.shifts.push_back(frame_at(shift.end_us));
  }
  run.frames = saved_frames(folder / "frames", run.metrics);
  run.has_pictures = !run.frames.empty();
  if (!run.has_pictures) {
    run.frames = frames_without_pictures(run);
    run.window_us = usual_window_us(run.metrics);
  }
  read_events(run);
  if (!run.truth.empty() && !run.sparse_truth()) {
    for (const auto& [name, score] : run.metrics.detectors) {
      run.found.push_back(found_at_chances(run.truth, run.detections, name, score.threshold));
    }
  }
  return run;
}

/// The detector's name with its colour.
std::string detector_mark(const Metrics& metrics, std::size_t index) {
  return colour_mark(detector_colour(index), metrics.detectors[index].first);
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

/// What the gaze was driven by.
std::string gaze_facts(const GazeMetrics& gaze) {
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

std::string share_row(std::string_view what,
                      const std::vector<std::pair<std::string, std::optional<double>>>& shares) {
  std::string html = fmt::format("<tr><th>{}</th>", what);
  for (const auto& [name, share] : shares) html += fmt::format("<th>{}</th>{}", escaped(name), cell(share));
  return html + "</tr>\n";
}

/// Who made the events; empty where nobody knows.
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

std::string summary(const Metrics& m) {
  std::string html = fmt::format("<p class=\"facts\">{:.3g} s", m.duration_s);
  if (m.seed) html += fmt::format(" · seed {}", *m.seed);
  for (const auto& [key, value] : m.settings) html += fmt::format(" · {} = {}", escaped(key), escaped(value));
  html += fmt::format(" · {} events", m.event_count);
  if (m.duration_s > 0.0)
    html += fmt::format(" ({:.3g} thousand per s)", static_cast<double>(m.event_count) * 1e-3 / m.duration_s);
  if (m.wall_s && *m.wall_s > 0.0) {
    html += fmt::format(" · computed in {:.3g} s ({:.2g} × real time)", *m.wall_s, m.duration_s / *m.wall_s);
  }
  return html + "</p>\n";
}

template <class Rows>
auto newest(const Rows& rows, std::int64_t t_us) {
  const auto after = std::upper_bound(rows.begin(), rows.end(), t_us,
                                      [](std::int64_t t, const auto& row) { return t < row.t_us; });
  return after == rows.begin() ? rows.end() : after - 1;
}

cv::Mat grey_picture(const fs::path& path, ImageSize size) {
  const cv::Mat grey = cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
  if (grey.cols != size.width || grey.rows != size.height) {
    throw InputError(path.string(), fmt::format("a picture of {} x {} pixels", grey.cols, grey.rows),
                     fmt::format("{} x {}, as the camera", size.width, size.height));
  }
  return grey;
}

std::optional<Circle> truth_at(const std::vector<TruthRow>& truth, std::int64_t t_us) {
  const auto row = newest(truth, t_us);
  const bool known =
      row != truth.end() && t_us - row->t_us < 1'000 && row->visible > 0.0 && std::isfinite(row->circle.x_px);
  return known ? std::optional(row->circle) : std::nullopt;
}

/// What the detector took for the ball last, in the time whose events are shown.
std::optional<Circle> accepted_at(const Run& run, std::size_t detector, std::int64_t t_us,
                                  std::int64_t window_us) {
  const auto& [name, score] = run.metrics.detectors[detector];
  for (auto row = newest(run.detections, t_us); row != run.detections.end() && t_us - row->t_us < window_us;
       --row) {
    if (row->detector == name && row->score >= score.threshold) return row->circle;
    if (row == run.detections.begin()) break;
  }
  return std::nullopt;
}

/// The newest gaze target as the eye truly saw it; none before the first or behind the eye.
std::optional<Eigen::Vector2d> target_at(const Run& run, std::int64_t t_us) {
  const auto gaze = newest(run.gaze, t_us);
  const auto eye = newest(run.eye, t_us);
  if (!run.metrics.camera || gaze == run.gaze.end() || eye == run.eye.end() || !gaze->target_m.allFinite()) {
    return std::nullopt;
  }
  return run.metrics.camera->project(eye->root_from_left_cam().inverse() * gaze->target_m);
}

EyePicture eye_picture(const Run& run, const Frame& frame, std::int64_t window_us) {
  EyePicture eye;
  eye.size = run.metrics.image;
  if (!frame.eye.empty()) eye.grey = grey_picture(frame.eye, eye.size);
  eye.events = frame.events;
  eye.truth = truth_at(run.truth, frame.t_us);
  for (std::size_t i = 0; i < run.metrics.detectors.size(); ++i) {
    if (const auto circle = accepted_at(run, i, frame.t_us, window_us)) {
      eye.detections.push_back({*circle, "", detector_colour(i)});
    }
  }
  eye.target_px = target_at(run, frame.t_us);
  if (run.metrics.camera)
    eye.principal_px = Eigen::Vector2d(run.metrics.camera->cx_px, run.metrics.camera->cy_px);
  return eye;
}

EyePicture right_eye_picture(const Run& run, const Frame& frame) {
  EyePicture eye;
  const Camera& camera = run.metrics.right_eye->camera;
  eye.size = camera.size;
  if (!frame.right_eye.empty()) eye.grey = grey_picture(frame.right_eye, eye.size);
  eye.events = frame.other_events;
  eye.truth = truth_at(run.right_truth, frame.t_us);
  eye.principal_px = Eigen::Vector2d(camera.cx_px, camera.cy_px);
  return eye;
}

std::string moment(const Run& run, std::int64_t t_us) {
  return fmt::format("{:.2f} s", static_cast<double>(t_us - run.metrics.start_us) * 1e-6);
}

std::string target_mark() { return colour_mark(gaze_target_colour, "gaze target"); }

std::string framed(const std::string& picture, const std::string& caption) {
  return fmt::format("<div class=\"frame\">{}<p>{}</p></div>\n", picture, caption);
}

/// The frames whose Hough spaces are shown: those with events and the ball in sight where there are any.
std::vector<Frame> hough_frames(const Run& run) {
  std::vector<Frame> all;
  std::vector<Frame> with_ball;
  for (const Frame& frame : run.frames) {
    if (frame.responses.empty()) continue;
    all.push_back(frame);
    if (truth_at(run.truth, frame.t_us) && !frame.events.empty()) with_ball.push_back(frame);
  }
  return spread_out(with_ball.empty() ? all : with_ball, max_hough_frames);
}

/// The accumulated Hough space over the events (paper, Fig. 2).
std::string hough_figure(const Run& run) {
  const std::vector<Frame> frames = hough_frames(run);
  if (frames.empty()) return {};
  std::set<std::size_t> all;
  for (const Frame& frame : frames) {
    for (const auto& [detector, response] : frame.responses) all.insert(detector);
  }
  std::vector<std::size_t> shown(all.begin(), all.end());
  if (shown.size() > max_hough_detectors) {  // the first ones, and of the others the best
    const auto last = shown.begin() + (max_hough_detectors - 1);
    const auto precision = [&](std::size_t i) {
      return run.metrics.detectors[i].second.average_precision.value_or(0.0);
    };
    std::iter_swap(last, std::max_element(last, shown.end(), [&](std::size_t a, std::size_t b) {
                     return precision(a) < precision(b);
                   }));
    shown.resize(max_hough_detectors);
  }

  const int scale = std::max(1, hough_picture_px / run.metrics.image.width);
  std::string html;
  for (const Frame& frame : frames) {
    const std::string when = moment(run, frame.t_us);
    EyePicture image;
    image.size = run.metrics.image;
    if (!frame.eye.empty()) image.grey = grey_picture(frame.eye, image.size);
    image.truth = truth_at(run.truth, frame.t_us);
    html += fmt::format("<div class=\"hough\" style=\"grid-template-columns:repeat({},minmax(0,18rem))\">\n",
                        shown.size() + 1);
    html += framed(picture_html(draw_eye(image, scale), "jpeg", "the image at " + when), when);
    for (const std::size_t i : shown) {
      const auto response = frame.responses.find(i);
      if (response == frame.responses.end()) continue;
      const auto& [name, score] = run.metrics.detectors[i];
      EyePicture eye = image;
      eye.response = grey_picture(response->second.path, eye.size);
      eye.events = frame.events;
      if (const auto circle = accepted_at(run, i, frame.t_us, run.window_us)) {
        eye.detections.push_back({*circle, "", detector_colour(i)});
      }
      html += framed(
          picture_html(draw_eye(eye, scale), "jpeg", fmt::format("Hough space of {} at {}", name, when)),
          fmt::format("{} · strongest {}, threshold {}", detector_mark(run.metrics, i),
                      short_number(response->second.strongest), short_number(score.threshold)));
    }
    html += "</div>\n";
  }
  return figure_html(
      "Hough space over the events",
      fmt::format("Left: the image. Beside it for each detector the largest response over all radii at every "
                  "pixel, dark red (weak) over yellow to white (the strongest of that picture), over the "
                  "events of the last {:.3g} ms in purple. The ball's centre should be the one bright spot. "
                  "White with a dark rim is the true circle, coloured what the detector takes for the ball.",
                  static_cast<double>(run.window_us) * 1e-3),
      html);
}

std::string strip(const Run& run) {
  if (run.frames.empty() || run.metrics.image.pixels() <= 0) return {};
  const int scale = std::max(1, eye_picture_px / run.metrics.image.width);
  std::string html = "<div class=\"strip\">\n";
  for (const Frame& frame : run.frames) {
    const EyePicture eye = eye_picture(run, frame, run.window_us);
    std::string caption = moment(run, frame.t_us);
    std::string pictures;
    if (!frame.scene.empty()) {
      const cv::Mat scene = cv::imread(frame.scene.string(), cv::IMREAD_COLOR);
      if (scene.empty()) throw InputError(frame.scene.string(), "no readable picture", "a PNG file");
      const int width = std::min(scene_picture_px, scene.cols);
      pictures += picture_html(fit_into(scene, width, width * scene.rows / scene.cols), "jpeg",
                               "the scene at " + caption);
    }
    pictures += picture_html(draw_eye(eye, scale), "png", "what the left eye sees at " + caption);
    if (run.metrics.right_eye) {
      pictures += picture_html(draw_eye(right_eye_picture(run, frame), scale), "png",
                               "what the right eye sees at " + caption);
    }
    if (run.metrics.gaze && run.metrics.camera && eye.truth) {
      const Eigen::Vector3d ray = run.metrics.camera->ray(eye.truth->x_px, eye.truth->y_px);
      caption += fmt::format(" · ball {:.1f}° off the axis", std::atan(ray.head<2>().norm()) * deg_per_rad);
    }
    html += framed(pictures, caption);
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
  if (!run.eye.empty() && !run.gaze.empty())
    reading += " The " + target_mark() + " is what it was last told to look at.";
  if (run.metrics.right_eye) reading += " The left eye's picture comes first, then the right one's.";
  return figure_html("What happened", reading, html);
}

/// Detections that moved the gaze, and where it went (paper, Fig. 6).
std::string shifts_figure(const Run& run) {
  if (run.shifts.empty() || run.metrics.image.pixels() <= 0) return {};
  const int scale = std::max(1, eye_picture_px / run.metrics.image.width);
  std::string html = "<div class=\"strip\">\n";
  for (std::size_t i = 0; i < run.shifts.size(); ++i) {
    const Frame& frame = run.shifts[i];
    const EyePicture eye = eye_picture(run, frame, picture_window_us);
    std::string caption = fmt::format("({}) {}", static_cast<char>('a' + i), moment(run, frame.t_us));
    if (eye.target_px) {
      const Eigen::Vector3d ray = run.metrics.camera->ray(eye.target_px->x(), eye.target_px->y());
      caption += fmt::format(" · target {:.1f}° off the axis", std::atan(ray.head<2>().norm()) * deg_per_rad);
    }
    html += framed(picture_html(draw_eye(eye, scale), "png", "gaze shift at " + moment(run, frame.t_us)),
                   caption);
  }
  html += "</div>";
  return figure_html("Gaze shifts",
                     fmt::format("The largest ones in pairs: a detection becomes a {} away from the cross, "
                                 "where the eye points (a, c, "
                                 "...), and the eye has turned towards it (b, d, ...). The newest {} events "
                                 "of the last {} ms: green where "
                                 "it got brighter, magenta where it got darker; white with a dark rim is the "
                                 "true circle, coloured the "
                                 "detection.",
                                 target_mark(), events_per_shift, shift_window_us / 1'000),
                     html);
}

std::string detection_figures(const Run& run) {
  const Metrics& m = run.metrics;
  std::string html;
  const bool scored = std::any_of(m.detectors.begin(), m.detectors.end(),
                                  [](const auto& d) { return !d.second.pr_curve.empty(); });
  for (std::size_t i = 0; i < m.detectors.size(); ++i) {
    const auto& [name, score] = m.detectors[i];
    html += figure_html(
        name + (run.truth.empty() ? ": circles over time" : " against truth"),
        run.truth.empty() ? "Every dot is an observation above the threshold; a ball makes a smooth trace, "
                            "clutter makes scattered dots."
                          : "Dots are observations above the threshold; those that lie on the dark truth in "
                            "all three panels are right, gaps are times without an observation.",
        tracking_figure("track_" + file_part(name), run.truth, run.detections, name, score.threshold,
                        detector_colour(i), run.sparse_truth(), m.start_us),
        run.folder);
  }
  if (scored) {
    html += figure_html(
        "Precision and recall",
        "Each curve runs through all thresholds; the further up and right, the better. The square "
        "is the threshold in use.",
        precision_recall_figure("precision_recall", m), run.folder);
  }
  return html;
}

std::string rate_figures(const Run& run) {
  const Metrics& m = run.metrics;
  const EventCounts* events = run.event_counts ? &*run.event_counts : nullptr;
  if (!run.scored_every_ms()) {
    return figure_html("Events and detections per time",
                       "Events come where something moves in the image; observations above the threshold get "
                       "rare when the ball stands still in it.",
                       rates_figure("rates", events, {}, {}, run.detections, m, m.start_us), run.folder);
  }
  std::string html = figure_html(
      "Detection rate over time",
      "How often per second each detector is right, in bins of 100 ms, between the rate of events and the "
      "speed of the ball in the image. Events come where something moves: a detector that lives on them is "
      "fast where the ball is and may go blind where it stands still, while a frame camera gives 30 images "
      "per second at best. Gaps are times without the ball in sight.",
      rates_figure("rates", events, run.truth, run.found, run.detections, m, m.start_us), run.folder);
  const std::vector<double> speed_px_s = image_speed_px_s(run.truth);
  std::vector<DetectorSpeeds> speeds;
  for (std::size_t i = 0; i < m.detectors.size(); ++i) {
    speeds.push_back({{m.detectors[i].first, detector_colour(i)}, {}});
    speeds.back().counts.add(run.found[i], speed_px_s);
  }
  return html +
         figure_html("Detection rate over the ball's speed",
                     "The same, sorted by the speed of the ball in the image. 1000 per second is a ball "
                     "found at every millisecond; speeds seen for less than 50 ms are left out.",
                     rate_over_speed_figure("rate_over_speed", speeds), run.folder);
}

std::string rejected_remark(const Metrics& m) {
  std::string html;
  for (const auto& [name, score] : m.detectors) {
    const RejectedEvents rejected = score.rejected_events.value_or(RejectedEvents{});
    if (rejected.outside_image + rejected.back_in_time == 0) continue;
    html += fmt::format(
        "<p class=\"remark\">{} left out {} events outside the image and {} that go back in time.</p>\n",
        escaped(name), rejected.outside_image, rejected.back_in_time);
  }
  return html;
}

std::string gaze_figures(const Run& run) {
  const Metrics& m = run.metrics;
  std::string html;
  if (!m.gaze || run.gaze.empty()) return html;
  const GazeTables tables{.truth = run.truth, .gaze = run.gaze, .eye = run.eye};
  html += shifts_figure(run);
  if (!run.eye.empty()) {
    html += figure_html(
        "Gaze over time",
        "Above: how far the ball is from the left eye's optical axis, low is good, and when the gaze was "
        "handed "
        "a target; what it was before the ball was acquired may lie outside. Below: how fast the eye turns. "
        "Bands are saccades, faster than 60°/s for 10 ms or more: a gaze that follows in jerks has many and "
        "an "
        "error like a saw's teeth between them.",
        gaze_over_time_figure("gaze_over_time", tables, m.camera, m.gaze->score.acquired_at_us, m.start_us),
        run.folder);
  }
  const std::vector<Saccade> saccades = saccades_of(run.eye);
  if (saccades.size() >= enough_saccades) {
    html +=
        figure_html("Saccades",
                    "Each saccade's peak speed over its size; eyes that move alike lie on one line through "
                    "the origin or below it. When each began stands in the numbers.",
                    main_sequence_figure("saccades", saccades, m.start_us), run.folder);
  }
  html += figure_html("Gaze in the robot's frame",
                      "Left: the plane before the robot as it sees it; right: seen from its right, with the "
                      "depth. A gaze that "
                      "follows well lays the blue line on the ball's grey path; the dots are the detections "
                      "that it was told to "
                      "look at. What lies far from the ball is outside.",
                      gaze_places_figure("gaze_places", std::vector<GazePlace>{{"", tables, m.start_us}}),
                      run.folder);
  html += figure_html(
      "Joints and their limits",
      "Blue: joint angle, dashed: limits; where the line runs along a limit the head cannot turn further.",
      joints_figure("joints", run.gaze, m.gaze->limits, m.start_us), run.folder);
  return html;
}

std::string body(const Run& run) {
  const Metrics& m = run.metrics;
  std::string html = summary(m);
  if (!run.events_remark.empty()) {
    html += fmt::format("<p class=\"remark\">Events are not shown: {}</p>\n", escaped(run.events_remark));
  }
  if (fs::exists(run.folder / "video.mp4")) html += "<p><a href=\"video.mp4\">The run as a film</a></p>\n";
  html += strip(run);
  if (m.gaze)
    html += "<h2>Gaze</h2>\n" + gaze_facts(*m.gaze) + gaze_table(*m.gaze, m.duration_s) + gaze_figures(run);
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

void write_report(const fs::path& run_folder) {
  const Run run = load(run_folder);
  write_page(run_folder, run.metrics.scenario, body(run));
}

}  // namespace saccade
