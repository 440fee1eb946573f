#include "session/replay_source.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "config/head_section.h"
#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "recording/number_text.h"
#include "recording/run_file_names.h"

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

/// A table of the joints of `head`, in the head's slots: the table's own reader has the names of the columns alone, from
/// which it cannot tell the joints of a torso of one's own from others.
JointsSource joints_of(const std::filesystem::path& path, const HeadModel& head) {
  std::string header;
  std::getline(std::ifstream(path, std::ios::binary), header);
  std::vector<std::string> names;
  std::string expected = "t_us";
  for (const HeadJoint& joint : head.joints) {
    names.push_back(joint.name);
    expected += "," + joint.name + "_rad";
  }
  if (without_mark(header) != expected)
    throw InputError(path.string() + ":1", header, "the header " + expected);
  auto table = std::make_shared<TableReader<JointsRow>>(path);
  std::vector<std::pair<int, int>> slots;  // in the table's rows, of the head
  const auto columns = head_of_names(names);
  for (std::size_t i = 0; i < names.size(); ++i)
    slots.emplace_back(columns->joints[i].slot, head.joints[i].slot);
  return JointsSource([table, slots]() -> std::optional<JointsRow> {
    std::optional<JointsRow> row = table->next();
    if (!row) return row;
    const JointVector in_table = row->position_rad;
    row->position_rad.setZero();
    for (const auto& [from, to] : slots) row->position_rad[to] = in_table[from];
    return row;
  });
}

Beginning beginning_of(const ReplaySource& source) {
  constexpr std::size_t looked_at = 1 << 18;
  const auto reader = open_event_file(source.formats, source.events, source.read);
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

ReplaySource open_replay_source(const ReadOptions& options, std::filesystem::path truth) {
  ReplaySource source;
  source.events = options.recording;
  source.formats = options.formats;
  if (is_run_folder(options)) {
    const Metrics metrics = read_metrics(options.recording / "metrics.json");
    source.events = options.recording / metrics.events_file;
    source.eye = played_eye(options, source.events);
    const bool right = source.eye == Eye::right;
    if (right && metrics.right_eye) {
      source.camera = metrics.right_eye->calibration;
    } else if (metrics.camera) {
      source.camera = metrics.calibration.value_or(MountedCamera{*metrics.camera, {}});
    }
    source.head = recorded_head(options.recording);
    const std::filesystem::path own_truth = options.recording / (right ? "truth_right.csv" : "truth.csv");
    if (truth.empty() && std::filesystem::exists(own_truth)) {
      truth = own_truth;
      if (metrics.seed) source.chances = Chances::simulated;
    }
  } else {
    source.eye = played_eye(options, source.events);
  }
  source.read = options.read;
  source.read.camera = static_cast<std::uint8_t>(source.eye);
  if (!truth.empty()) source.truth = read_table<TruthRow>(truth);
  return source;
}

std::optional<RecordedHead> recorded_head(const std::filesystem::path& folder) {
  const std::filesystem::path joints = folder / "joints.csv";
  if (!std::filesystem::exists(joints)) return std::nullopt;
  for (const char* const file : {run_file::scenario, run_file::robot}) {
    const std::optional<HeadConfig> config = read_recorded_head(folder / file);
    if (!config) continue;
    std::shared_ptr<const HeadModel> head = head_model(*config);
    RecordedHead recorded{joints_of(joints, *head), {}, recorded_imu(folder)};
    recorded.limits.head = std::move(head);
    return recorded;
  }
  return RecordedHead{TableReader<JointsRow>(joints), {}, recorded_imu(folder)};
}

void add_joints(ReplaySource& source, const std::filesystem::path& joints) {
  const std::filesystem::path file = std::filesystem::is_directory(joints) ? joints / "data.log" : joints;
  const auto open = [&](std::int64_t host_ahead_us) -> JointsSource {
    if (is_head_log(file)) return open_head_log(file, host_ahead_us);
    return TableReader<JointsRow>(file);
  };
  const Beginning events = beginning_of(source);
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
  source.head.emplace(RecordedHead{joints_from(open(events.host_ahead_us), wanted_us), {}});
}

}  // namespace saccade
