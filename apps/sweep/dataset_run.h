#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/sweep/sweep_engine.h"
#include "config/registry.h"

namespace saccade {

/// How make_dataset() runs.
struct DatasetOptions {
  std::filesystem::path file;            ///< of the data set
  std::filesystem::path out;             ///< its folder; empty: datasets/NAME
  bool retry = false;                    ///< make failed runs again
  std::vector<std::string> assignments;  ///< for the scenarios of all runs
  SweepEngineConfig engine;
  std::string program;  ///< identifies it: a data set is made by one program
};

/// Makes the missing runs of a data set, each split a sweep in a folder of its own, then card.json and card.md. A folder
/// belongs to one plan: the same runs of the same program. Returns the exit status: 0, or 1 if a run failed; there is no
/// card then. Throws InputError before the first run, RunError.
int make_dataset(const DatasetOptions& options, const Registry& registry);

/// Compares every file of a data set with its card and prints what differs. Returns the exit status: 0 equal, 3 different.
/// Throws InputError for a folder that is no whole data set.
int check_dataset(const std::filesystem::path& folder);

}  // namespace saccade
