#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "control/head_kinematics.h"
#include "core/camera.h"
#include "evaluation/scoring/scoring.h"
#include "recording/event_file.h"
#include "robot/replay/replay_robot.h"

namespace saccade {

/// A recording that a subcommand reads, and how to read it.
struct ReadOptions {
  std::filesystem::path recording;
  EventReadOptions read;
};

/// Whether the path is the folder of a run or of detect; otherwise it is a file, or a folder with an event-driven log.
[[nodiscard]] bool is_run_folder(const std::filesystem::path& recording);
/// The event file of a run folder, as its metrics.json names it; any other path unchanged. Throws InputError if
/// metrics.json is missing or broken.
[[nodiscard]] std::filesystem::path events_of(const std::filesystem::path& recording);

/// A recording to replay: a bare event file, or a run folder with its camera, joints and ground truth.
struct Played {
  std::filesystem::path events;
  EventReadOptions read;  ///< of the events of one eye
  Eye eye = Eye::left;
  MountedCamera camera{Camera{}.without_lens(), {}};  // a bare recording: unknown camera
  std::optional<RecordedHead> head;
  std::vector<TruthRow> truth;
  Chances chances = Chances::annotated;
};

/// Opens a recording. `truth`: table of true circles; if empty, the run folder's own, if it has one. Throws InputError for
/// a missing or broken file.
[[nodiscard]] Played open_played(const ReadOptions& options, std::filesystem::path truth);

/// Gives a recording the joints of a file, in place of its own: joints.csv of a run folder, or the log of a data dumper at
/// the head's state port (open_head_log; a folder with data.log too). The log's times are put into the events' clock by
/// the host's times in an event-driven log; in other recordings both have to have one clock. Throws InputError for a
/// missing or broken file, and where all joints are before the first event.
void add_joints(Played& played, const std::filesystem::path& joints);

}  // namespace saccade
