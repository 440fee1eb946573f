#include "apps/session/played.h"

#include <algorithm>
#include <cstdlib>

#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

/// The eye whose events the detectors get: that of the option, else the left one; the right one if the recording's first
/// block has events of the right eye alone.
Eye played_eye(const ReadOptions& options, const std::filesystem::path& events) {
  if (options.read.camera) return static_cast<Eye>(*options.read.camera);
  std::vector<Event> block;
  open_event_file(options.formats, events, options.read)->read(block, 1 << 16);
  const bool right =
      !block.empty() && std::ranges::all_of(block, [](const Event& e) { return e.camera == 1; });
  return right ? Eye::right : Eye::left;
}

std::string in_seconds(std::int64_t t_us) {
  std::string text = t_us < 0 ? "-" : "";
  append_seconds(text, std::abs(t_us));
  return text;
}

/// The first event of a recording, and how far the host's clock is ahead of the events'.
struct Beginning {
  std::optional<std::int64_t> first_us;
  std::int64_t host_ahead_us = 0;
};

Beginning beginning_of(const Played& played) {
  constexpr std::size_t looked_at = 1 << 18;
  const auto reader = open_event_file(played.formats, played.events, played.read);
  std::vector<Event> events;
  while (events.size() < looked_at && reader->read(events, looked_at) > 0) {
  }
  Beginning beginning;
  if (!events.empty()) beginning.first_us = events.front().t_us;
  beginning.host_ahead_us = reader->host_ahead_us().value_or(0);
  return beginning;
}

}  // namespace

bool is_run_folder(const ReadOptions& options) {
  const std::filesystem::path& recording = options.recording;
  return std::filesystem::is_directory(recording) && options.formats.file_of(recording) == recording;
}

std::filesystem::path events_of(const ReadOptions& options) {
  if (!is_run_folder(options)) return options.recording;
  return options.recording / read_metrics(options.recording / "metrics.json").events_file;
}

Played open_played(const ReadOptions& options, std::filesystem::path truth) {
  Played played;
  played.events = options.recording;
  played.formats = options.formats;
  if (is_run_folder(options)) {
    const Metrics metrics = read_metrics(options.recording / "metrics.json");
    played.events = options.recording / metrics.events_file;
    played.eye = played_eye(options, played.events);
    const bool right = played.eye == Eye::right;
    if (right && metrics.right_eye) {
      played.camera = metrics.right_eye->calibration;
    } else if (metrics.camera) {
      played.camera = metrics.calibration.value_or(MountedCamera{*metrics.camera, {}});
    }
    const std::filesystem::path joints = options.recording / "joints.csv";
    // The head gets no commands, so its limits are not used.
    if (std::filesystem::exists(joints))
      played.head.emplace(RecordedHead{TableReader<JointsRow>(joints), {}});
    const std::filesystem::path own_truth = options.recording / (right ? "truth_right.csv" : "truth.csv");
    if (truth.empty() && std::filesystem::exists(own_truth)) {
      truth = own_truth;
      if (metrics.seed) played.chances = Chances::simulated;
    }
  } else {
    played.eye = played_eye(options, played.events);
  }
  played.read = options.read;
  played.read.camera = static_cast<std::uint8_t>(played.eye);
  if (!truth.empty()) played.truth = read_table<TruthRow>(truth);
  return played;
}

void add_joints(Played& played, const std::filesystem::path& joints) {
  const std::filesystem::path file = std::filesystem::is_directory(joints) ? joints / "data.log" : joints;
  const auto open = [&](std::int64_t host_ahead_us) -> JointsSource {
    if (is_head_log(file)) return open_head_log(file, host_ahead_us);
    return TableReader<JointsRow>(file);
  };
  const Beginning events = beginning_of(played);
  JointsSource all = open(events.host_ahead_us);
  std::optional<JointsRow> row = all.next();
  if (!row) throw InputError(file.string(), "no joints", "at least one row");
  const std::int64_t first_us = row->t_us;
  std::int64_t last_us = first_us;
  const std::int64_t wanted_us = events.first_us.value_or(first_us);
  for (; row && last_us < wanted_us; row = all.next()) last_us = row->t_us;
  if (last_us < wanted_us) {
    throw InputError(file.string(),
                     "joints from " + in_seconds(first_us) + " to " + in_seconds(last_us) +
                         " s, before the first event at " + in_seconds(wanted_us) + " s",
                     "joints in the clock of the events");
  }
  played.head.emplace(RecordedHead{joints_from(open(events.host_ahead_us), wanted_us), {}});
}

}  // namespace saccade
