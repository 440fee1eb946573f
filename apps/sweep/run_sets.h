#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/report/resolved_scenario.h"

namespace saccade {

/// Runs that differ in their seeds alone.
struct SeedRuns {
  std::string label;  ///< the scenario's name with its settings; in a sweep the values of the axes
  ResolvedKeys keys;  ///< of one of the runs; empty where the folder has no resolved configuration
  std::vector<std::string> seeds;
  /// By path in metrics.json, one value for each seed: none where the figure does not apply in that run or is absent.
  std::map<std::string, std::vector<std::optional<double>>> figures;
};

/// What `saccade compare` is given on one side.
struct RunSet {
  std::filesystem::path path;
  std::vector<std::string> versions;  ///< "saccade 0.1.0 (9b6774e)", each once
  std::vector<SeedRuns> groups;       ///< in the order of their labels
  std::size_t runs = 0;
  std::size_t failed = 0;  ///< runs without a result: failed, interrupted, or not complete
};

/// Reads a run folder, the folder of a sweep, or a folder whose subfolders are runs (other subfolders are ignored). A run
/// folder with a configuration and no metrics counts as failed, and so does an interrupted run. Figures
/// are the numbers of figures.json, or of metrics.json without those of the wall clock. Throws InputError where there
/// is no run, RunError for a file that cannot be read.
[[nodiscard]] RunSet read_run_set(const std::filesystem::path& path);

}  // namespace saccade
