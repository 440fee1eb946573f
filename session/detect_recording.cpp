#include "session/detect_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

#include "config/cameras.h"
#include "config/input_files.h"
#include "config/scenario.h"
#include "core/error.h"
#include "core/units.h"
#include "evaluation/report/report.h"
#include "recording/run_file_names.h"
#include "robot/replay/replay_robot.h"
#include "session/annotated_ticks.h"
#include "session/interrupt.h"
#include "session/recorded_scores.h"
#include "session/run_folder.h"
#include "session/scenario_loop.h"
#include "session/session.h"
#include "session/summary.h"

namespace saccade {
namespace {

void run_at(std::span<const TruthRow> truth, std::int64_t start_us, Session& session,
            RecordedScores& scores) {
  std::vector<std::int64_t> times;
  std::ranges::transform(truth, std::back_inserter(times), &TruthRow::t_us);
  tick_at_annotated(times, start_us, [&](std::int64_t t_us, bool scoring) {
    if (interrupted()) return false;
    scores.set_scoring(scoring);
    return session.tick(t_us);
  });
}

struct TimeSpan {
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
};

std::string seconds(TimeSpan span) {
  return fmt::format("from {:.3f} to {:.3f} s", static_cast<double>(span.first_us) * 1e-6,
                     static_cast<double>(span.last_us) * 1e-6);
}

/// Of all events of a file; none where it has none.
std::optional<TimeSpan> event_span(const ReplaySource& source, const FormatRegistry& formats) {
  constexpr std::size_t block_events = 1 << 16;
  const auto reader = open_event_file(formats, source.events, source.read);
  std::optional<TimeSpan> span;
  std::vector<Event> block;
  for (; reader->read(block, block_events) > 0; block.clear()) {
    for (const Event& event : block) {
      if (!span) span = TimeSpan{event.t_us, event.t_us};
      span->first_us = std::min(span->first_us, event.t_us);
      span->last_us = std::max(span->last_us, event.t_us);
    }
  }
  return span;
}

/// Throws InputError where no row of truth lies in the time of the events.
void check_truth_span(const ReplaySource& source, const FormatRegistry& formats,
                      std::optional<std::int64_t> last_event_us, std::int64_t start_us,
                      const std::string& place) {
  const TimeSpan truth{source.truth.front().t_us, source.truth.back().t_us};
  const bool before = truth.last_us < start_us;
  const bool after = last_event_us && truth.first_us - sparse_window_us > *last_event_us;
  if (!before && !after) return;
  const std::optional<TimeSpan> events = event_span(source, formats);
  if (!events) return;
  throw InputError(place, fmt::format("truth {}, events {}", seconds(truth), seconds(*events)),
                   fmt::format("truth in the clock of the events; with {} us added to its t_us both start at "
                               "the same time",
                               events->first_us - truth.first_us));
}

void print_left_out(const std::string& recording, const ReplayRobot& robot) {
  const RejectedEvents rejected = robot.rejected();
  if (rejected.back_in_time + rejected.outside_image > 0) {
    fmt::print(stderr, "saccade: {}: left out {} events that go back in time and {} outside the image\n",
               recording, rejected.back_in_time, rejected.outside_image);
  }
  if (robot.events_before_start() > 0) {
    fmt::print(stderr, "saccade: {}: left out {} events before the first row of joints\n", recording,
               robot.events_before_start());
  }
}

/// Adds to a recording what the settings say of it.
void apply(const DetectSettings& settings, ReplaySource& source) {
  if (!settings.joints.empty()) add_joints(source, settings.joints);
  if (!settings.calibration.empty()) source.camera = read_calibration(settings.calibration);
  if (!settings.no_ball) return;
  if (std::ranges::any_of(source.truth, has_circle))
    throw InputError("--no-ball", "a recording whose truth has a ball", "a recording without one");
  source.chances = Chances::simulated;
}

/// The assumed calibration for images of that size.
MountedCamera fitting_camera(const DetectSettings& settings, const ReplaySource& source, ImageSize size) {
  MountedCamera camera = source.camera;
  if (!settings.calibration.empty() && camera.camera.size != size)
    throw InputError(settings.calibration.string(), in_words(camera.camera.size),
                     "a calibration for the recording's images, " + in_words(size));
  if (settings.calibration.empty() && !settings.joints.empty() && camera.camera.size != size)
    camera.camera = pinhole_camera(size);
  camera.camera.size = size;
  return camera;
}

/// What the detectors and their scores come from.
std::vector<FileDigest> files_read(const NamedDetectors& named, const DetectSettings& settings,
                                   const ReplaySource& source) {
  std::vector<FileDigest> files;
  const auto add = [&](const char* key, const std::filesystem::path& path) {
    if (!path.empty() && std::filesystem::exists(path))
      files.push_back({key, std::filesystem::absolute(path).string(), digest_of_file(path)});
  };
  add("recording", source.events);
  add("truth", settings.truth);
  add("joints", settings.joints);
  add("calibration", settings.calibration);
  if (is_run_folder(settings.input)) {
    const std::filesystem::path& folder = settings.input.recording;
    const bool right = source.eye == Eye::right;
    if (settings.truth.empty()) add("truth", folder / (right ? run_file::truth_right : run_file::truth));
    if (settings.joints.empty()) add("joints", folder / run_file::joints);
  }
  const std::vector<FileDigest> of_detectors = InputFiles().of(named);
  files.insert(files.end(), of_detectors.begin(), of_detectors.end());
  return files;
}

template <class Row>
void write_table(const std::filesystem::path& path, std::span<const Row> rows) {
  TableWriter<Row> table(path);
  for (const Row& row : rows) table.write(row);
  table.commit();
}

}  // namespace

void detect_recording(const NamedDetectors& named, const DetectSettings& settings) {
  ReplaySource source = open_replay_source(settings.input, settings.truth);
  apply(settings, source);
  const FormatRegistry& formats = settings.input.formats;
  const std::string recording = settings.input.recording.string();
  auto reader = open_event_file(formats, source.events, source.read);
  if (const std::string guess = reader->guess(); !guess.empty())
    fmt::print(stderr, "saccade: {}: guessed {}\n", source.events.string(), guess);
  ReplayRobot robot(std::move(reader), std::move(source.head));
  const MountedCamera camera = fitting_camera(settings, source, robot.image_size());
  Loop loop(robot, camera, make_detectors(named, camera.camera), std::nullopt, source.eye);
  std::unique_ptr<RunFolderLock> lock;
  if (!settings.folder.empty()) lock = prepare_run_folder(settings.folder, settings.force, formats);
  Observations observations(loop);
  RecordedScores scores(loop, observations, source.truth, source.chances,
                        settings.folder.empty() ? "" : settings.folder / "detections.csv");
  Metrics metrics;
  if (settings.json || !settings.folder.empty()) metrics.files = files_read(named, settings, source);

  catch_interrupts();
  const std::int64_t start_us = robot.now_us();
  Session session(robot, loop);
  session.add_observer(observations);
  session.add_observer(scores);
  if (settings.observe) {
    if (LoopObserver* const observer = settings.observe(loop, camera.camera.size))
      session.add_observer(*observer);
  }
  if (!source.truth.empty() && source.chances == Chances::annotated) {
    run_at(source.truth, start_us, session, scores);
  } else {
    session.run(observation_tick_us, std::numeric_limits<std::int64_t>::max(),
                source.truth.empty() ? 0 : source.truth.front().t_us);
  }
  const double wall_s = session.wall_s();
  metrics.interrupted = interrupted();
  if (metrics.interrupted) scores.leave_out_truth_after(robot.now_us());
  if (!source.truth.empty() && !metrics.interrupted)
    check_truth_span(source, formats, scores.last_event_us(), start_us,
                     settings.truth.empty() ? recording : settings.truth.string());
  const RejectedEvents rejected = robot.rejected();
  if (scores.event_count() == 0 && robot.events_before_start() > 0 && !metrics.interrupted)
    throw InputError(
        settings.joints.empty() ? recording : settings.joints.string(),
        fmt::format("joints from {:.3f} s on, after the last event", static_cast<double>(start_us) * 1e-6),
        "joints in the clock of the events");
  if (scores.event_count() + rejected.back_in_time + rejected.outside_image == 0 && !metrics.interrupted) {
    throw InputError(recording, "no events of a camera",
                     "a recording with some; saccade info lists its contents");
  }

  metrics.scenario = settings.input.recording.filename().string();
  if (robot.head() != nullptr || !settings.calibration.empty()) {
    metrics.camera = camera.camera;
    metrics.calibration = camera;
  }
  metrics.start_us = start_us;
  metrics.duration_s = static_cast<double>(robot.now_us() - start_us) * 1e-6;
  metrics.wall_s = wall_s;
  metrics.event_count = scores.event_count();
  metrics.events_file = std::filesystem::absolute(source.events).string();
  metrics.events_camera = source.read.camera;
  metrics.image = camera.camera.size;
  std::vector<DetectorScore> finished = scores.finish();
  for (std::size_t i = 0; i < named.size(); ++i)
    metrics.detectors.emplace_back(named[i].first, std::move(finished[i]));
  print_left_out(recording, robot);
  if (settings.folder.empty()) {
    if (settings.json) {
      fmt::print("{}", metrics_to_json(metrics));
    } else {
      print_summary(metrics);
    }
    if (interrupted()) throw RunError("interrupted; what was found until then is scored");
    throw_if_a_program_ended(metrics);
    return;
  }
  write_file(settings.folder / "detectors.yaml", resolved_detectors(named));
  if (!source.truth.empty()) write_table<TruthRow>(settings.folder / "truth.csv", scores.truth());
  write_metrics(settings.folder / run_file::metrics, metrics);
  write_figures(settings.folder / run_file::figures_json, metrics);
  finish_run_folder(settings.folder, metrics, formats);
}

}  // namespace saccade
