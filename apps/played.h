#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "apps/read_options.h"
#include "control/head_kinematics.h"
#include "core/camera.h"
#include "evaluation/scoring.h"
#include "robot/replay/replay_robot.h"

namespace saccade {

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
