#pragma once

#include <filesystem>
#include <functional>
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

class SweepCoordinator;
class SweepFolder;
struct SweepPlan;

/// What make_sweep() calls, with the folder locked.
using SweepStep = std::function<void(SweepCoordinator&, const SweepFolder&)>;
/// Makes the missing runs of a plan and their table in the folder `out`. `end` is called when every run has a result, `begin` before
/// the first one starts; it may be empty. `retry` and `task_flags` as SweepCoordinator takes
/// them. Throws InputError for a folder of something else or one that is in use, RunError.
void make_sweep(const SweepPlan& plan, const std::filesystem::path& out, const SweepEngineConfig& engine,
                bool retry, const std::vector<std::string>& task_flags, const SweepStep& end,
                const SweepStep& begin = {});

/// Makes the missing runs of a sweep, its table and its report. `version` identifies the program: runs of another version
/// are made again. Returns the exit status: 0, or 1 if a run failed. Throws InputError, RunError.
int sweep(const SweepOptions& options, const std::string& version, const Registry& registry);
/// Prints how many runs of the sweep in a folder are done, failed, running and waiting.
void print_sweep_status(const std::filesystem::path& folder);

/// "12 s", "3 min", "1.5 h".
[[nodiscard]] std::string duration_text(double s);

}  // namespace saccade
