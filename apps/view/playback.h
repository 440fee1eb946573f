#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/view/loop_history.h"
#include "apps/view/view_settings.h"
#include "session/replay_source.h"

namespace saccade {

/// A loop that a user plays, seeks in and changes: a simulated scenario or a recording. Used from one thread.
class Playback {
 public:
  static constexpr std::int64_t tick_us = 1'000;

  virtual ~Playback() = default;
  [[nodiscard]] virtual const LoopHistory& history() const = 0;
  /// Does the next tick. False, and nothing happens, at the end.
  virtual bool tick() = 0;
  /// Restores the latest checkpoint before t_us, goes on from now where that is nearer, or begins with what a run recorded
  /// (make_recording_playback()). Ticking on from there reproduces the original run. Throws what a detector or a controller throws that is made again, and nothing changes.
  virtual void restore_before(std::int64_t t_us) = 0;
  /// Takes effect from the next tick on. A detector that is new or has another configuration first processes the events
  /// of the last Snapshot::events_us. Throws InputError, or what a detector or a controller throws, and nothing changes.
  virtual void apply(const ViewSettings& settings) = 0;
  /// Fills all of a snapshot but playing, seeking, speed, request and problem.
  virtual void fill(Snapshot& snapshot) = 0;

  [[nodiscard]] virtual const ViewSettings& settings() const = 0;
  /// Number of events in equal parts of the recording's time; empty for a simulation.
  [[nodiscard]] virtual std::vector<float> event_counts() const = 0;
};

/// The simulated robot in a scenario. Its only checkpoint is the start.
/// Throws InputError for a scenario out of range, RunError where there is no OpenGL.
[[nodiscard]] std::unique_ptr<Playback> make_scenario_playback(const Scenario& scenario);

/// A recording, or a run folder with its camera, joints, truth and world. Its checkpoints hold copies of the detectors. The detectors
/// of a run, unchanged, show the estimates that it recorded, so that a seek over more than 1 s processes the last events alone.
/// `truth`: a table of true circles; empty: the run folder's own. `selected`: the name of the selected detector.
/// Throws InputError for files that are missing or broken and for a recording without events of the eye.
[[nodiscard]] std::unique_ptr<Playback> make_recording_playback(const ReadOptions& options,
                                                                const std::filesystem::path& truth,
                                                                const NamedDetectors& detectors,
                                                                const std::string& selected,
                                                                const Registry& registry);

}  // namespace saccade
