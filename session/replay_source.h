#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "control/head_kinematics.h"
#include "core/camera.h"
#include "evaluation/scoring/scoring.h"
#include "head/icub_cameras.h"
#include "recording/event_file.h"
#include "recording/format_registry.h"
#include "robot/replay/replay_robot.h"

namespace saccade {

/// A recording that a subcommand reads, and how to read it.
struct ReadOptions {
  std::filesystem::path recording;
  EventReadOptions read;
  FormatRegistry formats;  ///< of the program
};

/// Whether the recording is the folder of a run or of detect; otherwise it is a file, or a folder that is a recording of
/// one of the formats.
[[nodiscard]] bool is_run_folder(const ReadOptions& options);
/// The event file of a run folder, as its metrics.json names it; any other recording unchanged. Throws InputError if
/// metrics.json is missing or broken.
[[nodiscard]] std::filesystem::path events_of(const ReadOptions& options);

/// A recording to replay: a bare event file, or a run folder with its camera, joints and ground truth.
struct ReplaySource {
  std::filesystem::path events;
  EventReadOptions read;   ///< of the events of one eye
  FormatRegistry formats;  ///< of the program
  Eye eye = Eye::left;
  MountedCamera camera{icub_left_2016.without_lens(), {}};  // a bare recording: unknown camera
  std::optional<RecordedHead> head;
  std::vector<TruthRow> truth;
  Chances chances = Chances::annotated;
};

/// Opens a recording. `truth`: table of true circles; if empty, the run folder's own, if it has one. Throws InputError for
/// a missing or broken file.
[[nodiscard]] ReplaySource open_replay_source(const ReadOptions& options, std::filesystem::path truth);

/// The recorded joints of a run folder and its head: that of its scenario.yaml or robot.yaml, else the head that the names of
/// the columns give. None without joints.csv. The head of a replay gets no commands, so no limits are read.
[[nodiscard]] std::optional<RecordedHead> recorded_head(const std::filesystem::path& folder);

/// Gives a recording the joints of a file, in place of its own: joints.csv of a run folder, or the log of a data dumper at
/// the head's state port (open_head_log; a folder with data.log too). The log's times are put into the events' clock by
/// the host's times in an event-driven log; in other recordings both have to have one clock. Throws InputError for a
/// missing or broken file, and where all joints are before the first event.
void add_joints(ReplaySource& source, const std::filesystem::path& joints);

}  // namespace saccade
