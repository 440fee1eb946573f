#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/sweep/benchmark_list.h"
#include "apps/sweep/benchmark_result.h"
#include "apps/sweep/benchmark_worlds.h"
#include "apps/sweep/sweep_engine.h"
#include "config/registry.h"

namespace saccade {

/// How benchmark() and verify_benchmark() run.
struct BenchmarkOptions {
  std::filesystem::path list;  ///< list file
  std::filesystem::path out;   ///< folder of the entries
  bool quick = false;
  bool retry = false;         ///< make failed runs again
  std::string latency_class;  ///< of the entries; empty: each has that of its preset
  SweepEngineConfig engine;
  std::string version;  ///< identifies the program: runs of another version are made again
};

/// A name of the registry, a file with one detector, FILE.py:CLASS, or a program (both as external detectors). Without a key radius_px the detector gets that of each world.
/// Throws InputError.
[[nodiscard]] BenchmarkEntry benchmark_entry(const std::string& text, const Registry& registry);

/// Runs each world of the list once with all entries side by side, and the loops with each entry, into `out`/NAME: a folder as of a sweep for each part of the list, result.json and
/// report.html. Goes on where it was. Prints the table of the entries. Returns the exit status: 0, or 1 if a run failed;
/// its entry has no result then. Throws InputError before the first run, RunError.
int benchmark(const std::vector<std::string>& entries, const BenchmarkOptions& options,
              const Registry& registry);

/// Makes a tenth of the runs of a result again, from each part the first and every tenth after it, into `out`/ENTRY. Prints figures that differ by
/// more than verify_tolerance and worlds with other events. Returns the exit status: 0 equal, 3 different. Throws
/// InputError, RunError.
int verify_benchmark(const std::filesystem::path& result, const BenchmarkOptions& options,
                     const Registry& registry);
inline constexpr double verify_tolerance = 0.01;

/// Figures of a run by the wall clock, which verify_benchmark() does not compare, are those that end so.
inline constexpr const char* clock_figure = "us_per_event";

/// What sweep-task leaves of a run for the benchmark: figures that metrics.json does not have. `run`: its folder, with
/// tables and events. Throws InputError.
void write_benchmark_figures(const std::filesystem::path& run, const std::filesystem::path& file);

}  // namespace saccade
