#include "evaluation/report/run_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/error.h"
#include "core/units.h"
#include "evaluation/image_codecs/image_codecs.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/html.h"
#include "evaluation/report/run_tables.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr int eye_image_px = 384;
constexpr int scene_image_px = 512;
constexpr std::size_t max_hough_frames = 4;
constexpr std::size_t max_hough_detectors = 4;
constexpr int hough_image_px = 288;

template <class Rows>
auto newest(const Rows& rows, std::int64_t t_us) {
  const auto after = std::upper_bound(rows.begin(), rows.end(), t_us,
                                      [](std::int64_t t, const auto& row) { return t < row.t_us; });
  return after == rows.begin() ? rows.end() : after - 1;
}

cv::Mat grey_image(const fs::path& path, ImageSize size) {
  cv::Mat grey = read_image(path, DecodedAs::grey);
  if (grey.cols != size.width || grey.rows != size.height) {
    throw InputError(path.string(), fmt::format("an image of {} x {} pixels", grey.cols, grey.rows),
                     fmt::format("{} x {}, as the camera", size.width, size.height));
  }
  return grey;
}

/// The newest true circle that is not older.
std::optional<Circle> truth_at(const std::vector<TruthRow>& truth, std::int64_t t_us,
                               std::int64_t oldest_us = 1'000) {
  const auto row = newest(truth, t_us);
  const bool is_visible = row != truth.end() && t_us - row->t_us < oldest_us && row->visible > 0.0 &&
                          std::isfinite(row->circle.r_px);
  return is_visible ? std::optional(row->circle) : std::nullopt;
}

/// The detector's newest circle at or above its threshold, of the time whose events are shown.
std::optional<Circle> accepted_at(const RunData& run, std::size_t detector, std::int64_t t_us,
                                  std::int64_t window_us) {
  const auto& [name, score] = run.metrics.detectors[detector];
  for (auto row = newest(run.detections, t_us); row != run.detections.end() && t_us - row->t_us < window_us;
       --row) {
    if (row->detector == name && row->score >= score.threshold) return row->circle;
    if (row == run.detections.begin()) break;
  }
  return std::nullopt;
}

/// The newest gaze target in the true image; none before the first or behind the eye.
std::optional<Eigen::Vector2d> target_at(const RunData& run, std::int64_t t_us) {
  const auto gaze = newest(run.gaze, t_us);
  const auto eye = newest(run.eye, t_us);
  if (!run.metrics.camera || gaze == run.gaze.end() || eye == run.eye.end() || !gaze->target_m.allFinite()) {
    return std::nullopt;
  }
  return run.metrics.camera->project(eye->root_from_left_cam().inverse() * gaze->target_m);
}

std::string moment(const RunData& run, std::int64_t t_us) {
  return fmt::format("{:.2f} s", static_cast<double>(t_us - run.metrics.start_us) * 1e-6);
}

std::string target_mark() { return colour_mark(gaze_target_colour, "gaze target"); }
std::string on_mark() { return colour_mark(on_colour, "ON (brighter)"); }
std::string off_mark() { return colour_mark(off_colour, "OFF (darker)"); }
std::string truth_mark() { return colour_mark(truth_colour, "truth"); }

std::string framed(const std::string& image, const std::string& caption) {
  return fmt::format("<div class=\"frame\">{}<p>{}</p></div>\n", image, caption);
}

/// The frames whose Hough spaces are shown: those with events and the ball in sight where there are any.
std::vector<Frame> hough_frames(const RunData& run) {
  std::vector<Frame> all;
  std::vector<Frame> with_ball;
  for (const Frame& frame : run.frames) {
    if (frame.responses.empty()) continue;
    all.push_back(frame);
    if (truth_at(run.truth, frame.t_us) && !frame.events.empty()) with_ball.push_back(frame);
  }
  return evenly_spaced(with_ball.empty() ? all : with_ball, max_hough_frames);
}

}  // namespace

AnnotatedImage left_image(const RunData& run, const Frame& frame, std::int64_t window_us, CircleNames names) {
  AnnotatedImage eye;
  eye.size = run.metrics.image;
  if (!frame.eye.empty()) eye.grey = grey_image(frame.eye, eye.size);
  eye.events = frame.events;
  eye.truth =
      run.sparse_truth() ? truth_at(run.truth, frame.t_us, window_us) : truth_at(run.truth, frame.t_us);
  for (std::size_t i = 0; i < run.metrics.detectors.size(); ++i) {
    const std::string& name = run.metrics.detectors[i].first;
    if (const auto circle = accepted_at(run, i, frame.t_us, window_us))
      eye.detections.push_back({*circle, names == CircleNames::yes ? name : "", detector_colour(name)});
  }
  eye.target_px = target_at(run, frame.t_us);
  if (run.metrics.camera)
    eye.principal_px = Eigen::Vector2d(run.metrics.camera->cx_px, run.metrics.camera->cy_px);
  return eye;
}

AnnotatedImage right_image(const RunData& run, const Frame& frame) {
  AnnotatedImage eye;
  const Camera& camera = run.metrics.right_eye->camera;
  eye.size = camera.size;
  if (!frame.right_eye.empty()) eye.grey = grey_image(frame.right_eye, eye.size);
  eye.events = frame.other_events;
  eye.truth = truth_at(run.right_truth, frame.t_us);
  eye.principal_px = Eigen::Vector2d(camera.cx_px, camera.cy_px);
  return eye;
}

std::string hough_figure(const RunData& run) {
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

  const int scale = std::max(1, hough_image_px / run.metrics.image.width);
  std::map<std::size_t, double> white;  // the response that is drawn white, by detector
  for (const Frame& frame : frames) {
    for (const auto& [detector, response] : frame.responses)
      white[detector] = std::max(white[detector], response.strongest);
  }
  std::string html;
  for (const Frame& frame : frames) {
    const std::string when = moment(run, frame.t_us);
    AnnotatedImage image;
    image.size = run.metrics.image;
    if (!frame.eye.empty()) image.grey = grey_image(frame.eye, image.size);
    image.truth = truth_at(run.truth, frame.t_us);
    html += fmt::format("<div class=\"hough\" style=\"grid-template-columns:repeat({},minmax(0,18rem))\">\n",
                        shown.size() + 1);
    html += framed(image_html(draw_image(image, scale), "jpeg", "the image at " + when), when);
    for (const std::size_t i : shown) {
      const auto response = frame.responses.find(i);
      if (response == frame.responses.end()) continue;
      const auto& [name, score] = run.metrics.detectors[i];
      AnnotatedImage eye = image;
      const double share = white[i] > 0.0 ? response->second.strongest / white[i] : 1.0;
      grey_image(response->second.path, eye.size).convertTo(eye.response, CV_8U, share);
      eye.events = frame.events;
      if (const auto circle = accepted_at(run, i, frame.t_us, run.window_us)) {
        eye.detections.push_back({*circle, "", detector_colour(run.metrics.detectors[i].first)});
      }
      html += framed(
          image_html(draw_image(eye, scale), "jpeg", fmt::format("Hough space of {} at {}", name, when)),
          fmt::format("{} · strongest {}, threshold {}", detector_mark(run.metrics, i),
                      short_number(response->second.strongest), short_number(score.threshold)));
    }
    html += "</div>\n";
  }
  return figure_html(
      "Hough space over the events",
      fmt::format("Left: the image. Beside it for each detector the largest response over all radii at every "
                  "pixel, dark red (weak) over yellow to white (the strongest of that detector in the images "
                  "shown: one scale for all of them), over the events of the last {:.3g} ms in grey. The "
                  "ball's centre should be the one bright spot. "
                  "{} is the true circle, the other one the detector's.",
                  static_cast<double>(run.window_us) * 1e-3, truth_mark()),
      html);
}

std::string frames_figure(const RunData& run) {
  if (run.frames.empty() || run.metrics.image.pixels() <= 0) return {};
  const int scale = std::max(1, eye_image_px / run.metrics.image.width);
  std::string html = "<div class=\"strip\">\n";
  for (const Frame& frame : run.frames) {
    const AnnotatedImage eye = left_image(run, frame, run.window_us);
    std::string caption = moment(run, frame.t_us);
    std::string images;
    if (!frame.scene.empty()) {
      const cv::Mat scene = read_image(frame.scene, DecodedAs::colour);
      if (scene.empty()) throw InputError(frame.scene.string(), "no readable image", "a PNG file");
      const int width = std::min(scene_image_px, scene.cols);
      images += image_html(fit_into(scene, width, width * scene.rows / scene.cols), "jpeg",
                           "the scene at " + caption);
    }
    images += image_html(draw_image(eye, scale), "png", "left eye at " + caption);
    if (run.metrics.right_eye) {
      images += image_html(draw_image(right_image(run, frame), scale), "png", "right eye at " + caption);
    }
    if (run.metrics.gaze && run.metrics.camera && eye.truth) {
      const Eigen::Vector3d ray = run.metrics.camera->ray(eye.truth->x_px, eye.truth->y_px);
      caption += fmt::format(" · ball {:.1f}° off the axis", std::atan(ray.head<2>().norm()) * deg_per_rad);
    }
    html += framed(images, caption);
  }
  html += "</div>";
  const bool has_events =
      std::ranges::any_of(run.frames, [](const Frame& frame) { return !frame.events.empty(); });
  std::string reading = has_events
                            ? fmt::format("Events of the last {:.3g} ms: {}, {}. ",
                                          static_cast<double>(run.window_us) * 1e-3, on_mark(), off_mark())
                            : "The events were not recorded. ";
  reading += run.truth.empty() ? "The circles" : truth_mark() + " is the true circle; the others";
  reading += " are the newest at or above the threshold of each detector:";
  for (std::size_t i = 0; i < run.metrics.detectors.size(); ++i) {
    reading += (i == 0 ? " " : ", ") + detector_mark(run.metrics, i);
  }
  reading += run.metrics.camera ? ". The cross marks the optical axis: a ball under it is fixated." : ".";
  if (!run.eye.empty() && !run.gaze.empty()) reading += " The diamond is the newest " + target_mark() + ".";
  if (run.metrics.right_eye) reading += " The left eye's image comes first, then the right one's.";
  return figure_html("The run in images", reading, html);
}

std::string shifts_figure(const RunData& run) {
  if (run.shifts.empty() || run.metrics.image.pixels() <= 0) return {};
  const int scale = std::max(1, eye_image_px / run.metrics.image.width);
  std::string html = "<div class=\"strip\">\n";
  for (std::size_t i = 0; i < run.shifts.size(); ++i) {
    const Frame& frame = run.shifts[i];
    const AnnotatedImage eye = left_image(run, frame, image_window_us);
    std::string caption = fmt::format("({}) {}", static_cast<char>('a' + i), moment(run, frame.t_us));
    if (eye.target_px) {
      const Eigen::Vector3d ray = run.metrics.camera->ray(eye.target_px->x(), eye.target_px->y());
      caption += fmt::format(" · target {:.1f}° off the axis", std::atan(ray.head<2>().norm()) * deg_per_rad);
    }
    html += framed(image_html(draw_image(eye, scale), "png", "gaze shift at " + moment(run, frame.t_us)),
                   caption);
  }
  html += "</div>";
  return figure_html(
      "Gaze shifts",
      fmt::format(
          "The largest ones in pairs: a detection becomes a {} away from the cross, which marks the optical "
          "axis (a, c, ...), and the eye has turned towards it (b, d, ...). The newest {} events of the last "
          "{} ms: {}, {}; {} is the true circle, the other one the detection.",
          target_mark(), events_per_shift, shift_window_us / 1'000, on_mark(), off_mark(), truth_mark()),
      html);
}

}  // namespace saccade
