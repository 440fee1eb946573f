#include "apps/session/played.h"

#include <algorithm>

#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"

namespace saccade {
namespace {

/// The eye whose events the detectors get: that of the option, else the left one; the right one if the recording's first
/// block has events of the right eye alone.
Eye played_eye(const ReadOptions& options, const std::filesystem::path& events) {
  if (options.read.camera) return static_cast<Eye>(*options.read.camera);
  std::vector<Event> block;
  open_event_file(events, options.read)->read(block, 1 << 16);
  const bool right =
      !block.empty() && std::ranges::all_of(block, [](const Event& e) { return e.camera == 1; });
  return right ? Eye::right : Eye::left;
}

}  // namespace

bool is_run_folder(const std::filesystem::path& recording) {
  return std::filesystem::is_directory(recording) && !is_log_folder(recording);
}

std::filesystem::path events_of(const std::filesystem::path& recording) {
  if (!is_run_folder(recording)) return recording;
  return recording / read_metrics(recording / "metrics.json").events_file;
}

Played open_played(const ReadOptions& options, std::filesystem::path truth) {
  Played played;
  played.events = options.recording;
  if (is_run_folder(options.recording)) {
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

}  // namespace saccade
