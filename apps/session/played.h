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

/// The recording that a subcommand reads, and what its file may leave open.
struct ReadOptions {
  std::filesystem::path recording;
  EventReadOptions read;
};

/// Whether the recording is the folder of a run, or of detect (else it is a file, or a folder with a log in it).
[[nodiscard]] bool is_run_folder(const std::filesystem::path& recording);
/// The events' file of a run folder, by its metrics.json; anything else as it is. Throws InputError where metrics.json
/// is missing or broken.
[[nodiscard]] std::filesystem::path events_of(const std::filesystem::path& recording);

/// What is played: a bare recording, or a run folder with its camera, joints and truth.
struct Played {
  std::filesystem::path events;
  EventReadOptions read;  ///< of the events of one eye
  Eye eye = Eye::left;
  MountedCamera camera{Camera{}.without_lens(), {}};  // nothing is known of the camera of a bare recording
  std::optional<RecordedHead> head;
  std::vector<TruthRow> truth;
  Chances chances = Chances::annotated;
};

/// Opens what the options name. `truth`: its table; where empty the run folder's own, if it has one.
/// Throws InputError for what is missing or broken.
[[nodiscard]] Played open_played(const ReadOptions& options, std::filesystem::path truth);

}  // namespace saccade
