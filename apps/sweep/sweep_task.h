#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/registry.h"

namespace saccade {

/// Which runs make_sweep_runs() makes.
struct SweepTaskOptions {
  std::filesystem::path folder;  ///< of the sweep
  std::vector<std::string> ids;
  bool worst = false;      ///< make them again, with pictures and a report
  bool benchmark = false;  ///< with benchmark.json, write_benchmark_figures()
  bool dataset = false;    ///< with the files of a data set, keep_dataset_run()
};

/// Makes runs of a sweep, each in a process of its own, and leaves its result or the reason of its failure in its folder.
/// Skips runs that have a result or that another process makes. Returns the exit status: 0, or stop_all_status if the
/// disk is full.
int make_sweep_runs(const SweepTaskOptions& options, const Registry& registry);

}  // namespace saccade
