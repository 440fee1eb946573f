#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/scenario.h"
#include "evaluation/scoring/metrics.h"
#include "loop/loop.h"
#include "sim/sim_robot.h"

namespace saccade {

/// How run_scenario() runs a scenario.
struct RunSettings {
  std::filesystem::path folder;          ///< run folder; empty: runs/NAME
  bool force = false;                    ///< replace an earlier run in that folder
  std::vector<std::string> assignments;  ///< overrides of the scenario, for metrics.json
  /// Called after each tick, in the thread of the run; may be empty.
  std::function<void(const Tick&, const SimRobot&, const Loop&)> show;
  /// Called before robot and loop end, also when the run throws; may be empty.
  std::function<void()> close;
};

/// One closed-loop run of a scenario into a run folder, with progress, log, summary and report, until its duration is
/// over or interrupted(). Returns the exit status: 0, or 3 for an unmet `expect:`. Throws InputError, and RunError also
/// after an interrupt; the folder is complete then.
int run_scenario(const Scenario& scenario, const RunSettings& settings);

/// The same without printing, pictures and report. With a folder, which exists, its tables, events and metrics.json are
/// written there; without one nothing is. `wrap` may replace detectors by others that pass everything on to them; it may
/// be empty.
[[nodiscard]] Metrics score_scenario(const Scenario& scenario,
                                     const std::optional<std::filesystem::path>& folder = std::nullopt,
                                     const std::function<void(std::vector<LoopDetector>&)>& wrap = {});

}  // namespace saccade
