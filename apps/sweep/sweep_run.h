#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/live/live_server.h"
#include "apps/sweep/sweep_engine.h"
#include "config/registry.h"

namespace saccade {

/// How sweep() runs.
struct SweepOptions {
  std::filesystem::path sweep;           ///< sweep file
  std::filesystem::path out;             ///< folder of the sweep; empty: sweeps/NAME
  std::filesystem::path csv;             ///< also write the table here; empty: no
  bool times = false;                    ///< in the table, the columns that depend on the clock
  bool retry = false;                    ///< make failed runs again
  std::vector<std::string> assignments;  ///< for the scenarios of all runs
  SweepEngineConfig engine;
  std::optional<LiveAddress> web;  ///< of the live page; none: there is none
};

/// Makes the missing runs of a sweep, its table and its report. `version` identifies the program: runs of another version
/// are made again. Returns the exit status: 0, or 1 if a run failed. Throws InputError, RunError.
int sweep(const SweepOptions& options, const std::string& version, const Registry& registry);
/// Prints how many runs of the sweep in a folder are done, failed, running and waiting.
void print_sweep_status(const std::filesystem::path& folder);

/// "12 s", "3 min", "1.5 h".
[[nodiscard]] std::string duration_text(double s);

}  // namespace saccade
