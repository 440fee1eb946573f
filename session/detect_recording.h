#pragma once

#include <filesystem>
#include <functional>

#include "config/sections.h"
#include "loop/loop.h"
#include "session/replay_source.h"

namespace saccade {

/// How detect_recording() runs.
struct DetectSettings {
  ReadOptions input;
  std::filesystem::path truth;        ///< table of true circles; empty: the run folder's own, if it has one
  std::filesystem::path joints;       ///< add_joints(); empty: the run folder's own, if it has some
  std::filesystem::path calibration;  ///< assumed calibration (read_calibration); empty: the run folder's own
  bool no_ball = false;               ///< the recording shows no ball: every observation is false
  std::filesystem::path folder;       ///< for detections, scores and report; empty: nothing is written
  bool force = false;                 ///< replace an earlier run in that folder
  /// Called before the first tick; what it returns sees every tick, and outlives the run. May be empty.
  std::function<LoopObserver*(const Loop& loop, ImageSize size)> observe = {};
  bool json = false;  ///< without a folder: print metrics.json instead of the summary
};

/// Runs detectors on a recording, scores them where truth is given, prints the summary and writes the folder. Ticks are at
/// whole milliseconds, or at those of the truth; with annotated truth they are the annotated instants and the starts of
/// their observation windows (docs/scoring.md). Without a calibration a bare recording with joints has the pinhole camera
/// of its image size. Throws
/// InputError for a recording without events, for truth or joints outside the recording's time span, and for truth with a
/// ball where there is to be none; RunError after an interrupt.
void detect_recording(const NamedDetectors& detectors, const DetectSettings& settings);

}  // namespace saccade
