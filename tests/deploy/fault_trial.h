#pragma once

#include <cstdint>
#include <string>

#include "tests/deploy/fault_kinds.h"

namespace saccade {

/// How a deployed robot in virtual time, beside its guard, answered its faults.
struct TrialResult {
  double stop_ms = 0.0;      ///< from the first fault to the stop command
  std::string problem = {};  ///< what was wrong; empty: safe
  bool stops = true;         ///< false where nothing had to stop
};

/// Runs a trial to the end. `with_gaze`: the robot has a gaze controller of its own. `number`: names the files of a
/// recording.
[[nodiscard]] TrialResult run_trial(const Faults& faults, bool with_gaze, std::uint64_t number);

}  // namespace saccade
