#include "evaluation/report/run_data.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/scoring/eye_movement.h"
#include "recording/event_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_frames = 12;
constexpr std::size_t frames_of_a_run_without_images = 8;
constexpr std::size_t max_gaze_shifts = 4;
constexpr double events_per_image = 1'500.0;  // of a run without images, as the paper's window

/// The detector whose Hough space an image shows, from its file name after the time: _<detector>_hough_<max>.png.
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

/// Images saved as <t_us>_eye.png, <t_us>_right_eye.png, <t_us>_scene.png and <t_us>_<detector>_hough_<max>.png.
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
  return evenly_spaced(sorted, max_frames);
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

std::vector<Frame> frames_without_images(const RunData& run) {
  std::vector<std::int64_t> times_us;
  for (const TruthRow& row : run.truth) {
    if (row.visible >= chance_visible_share) times_us.push_back(row.t_us);
  }
  if (times_us.empty()) {
    const auto end_us = static_cast<std::int64_t>(run.metrics.duration_s * 1e6);
    const std::int64_t step_us = end_us / (static_cast<std::int64_t>(frames_of_a_run_without_images) + 1);
    for (std::int64_t t_us = step_us; step_us > 0 && t_us < end_us; t_us += step_us) {
      times_us.push_back(run.metrics.start_us + t_us);
    }
  }
  std::vector<Frame> frames;
  for (const std::int64_t t_us : evenly_spaced(times_us, frames_of_a_run_without_images))
    frames.push_back(frame_at(t_us));
  return frames;
}

/// The mean time that as many events take as the paper's window holds.
std::int64_t usual_window_us(const Metrics& metrics) {
  const double mean_us = metrics.duration_s * 1e6 * events_per_image /
                         static_cast<double>(std::max<std::int64_t>(1, metrics.event_count));
  return 1'000 * std::llround(std::clamp(mean_us, 1e3, 2e5) * 1e-3);
}

/// Adds an event to the frames (sorted by time) at most `window_us` later; `camera` is the frames' own.
void show_event(std::vector<Frame>& frames, std::int64_t window_us, const Event& event, std::uint8_t camera) {
  const auto later = [](const Frame& frame, std::int64_t t_us) { return frame.t_us < t_us; };
  for (auto frame = std::lower_bound(frames.begin(), frames.end(), event.t_us, later);
       frame != frames.end() && frame->t_us - window_us < event.t_us; ++frame) {
    (event.camera == camera ? frame->events : frame->other_events).push_back(event);
  }
}

/// One pass over the recording: counts over time, and the events just before each frame.
void read_events(RunData& run, const FormatRegistry& formats) {
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
    const auto reader = open_event_file(formats, run.folder / metrics.events_file);
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

}  // namespace

std::int64_t report_step_ms(double duration_s) {
  constexpr double most_instants = 1 << 18;
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(duration_s * 1e3 / most_instants)));
}

RunData load_run(const fs::path& folder, const FormatRegistry& formats) {
  RunData run;
  run.folder = folder;
  run.metrics = read_metrics(folder / "metrics.json");
  const std::int64_t start_us = run.metrics.start_us;
  const std::int64_t step_ms = report_step_ms(run.metrics.duration_s);
  run.truth = read_thinned_table<TruthRow>(folder / "truth.csv", start_us, step_ms);
  run.right_truth = read_thinned_table<TruthRow>(folder / "truth_right.csv", start_us, step_ms);
  run.detections = read_thinned_table<DetectionRow>(folder / "detections.csv", start_us, step_ms);
  run.gaze = read_thinned_table<GazeRow>(folder / "gaze.csv", start_us, step_ms);
  run.eye = read_thinned_table<EyeRow>(folder / "eye.csv", start_us, step_ms);
  for (const GazeShift& shift : largest_gaze_shifts(run.gaze, run.eye, max_gaze_shifts)) {
    run.shifts.push_back(frame_at(shift.start_us));
    run.shifts.push_back(frame_at(shift.end_us));
  }
  run.frames = saved_frames(folder / "frames", run.metrics);
  run.has_images = !run.frames.empty();
  if (!run.has_images) {
    run.frames = frames_without_images(run);
    run.window_us = usual_window_us(run.metrics);
  }
  read_events(run, formats);
  if (!run.truth.empty() && !run.sparse_truth()) {
    for (const auto& [name, score] : run.metrics.detectors) {
      run.found.push_back(found_at_chances(run.truth, run.detections, name, score.threshold));
    }
  }
  return run;
}

}  // namespace saccade
