#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/sweep/sweep_config.h"
#include "config/registry.h"
#include "recording/file_digest.h"

namespace saccade {

/// One combination of values.
struct PlannedRun {
  /// A digest of scenario, seed, version and of what the run reads; equal for combinations that give the same run.
  std::string id;
  std::vector<std::size_t> values;  ///< for each axis the index of its value
  std::int64_t seed = 0;
  std::string scenario;  ///< with every default, as `saccade run` takes it, and files_text()
};

/// All runs of a sweep, in the order of its tables.
struct SweepPlan {
  SweepConfig config;
  std::string version;
  std::vector<std::string> metrics;  ///< that the report shows, the main one first
  std::vector<PlannedRun> runs;
};

/// What a run reads beside its scenario, as comments in YAML: a line per file with its digest.
[[nodiscard]] std::string files_text(const std::vector<FileDigest>& files);
/// The files among `files` that keys name and whose line `scenario` does not hold: they changed after the plan.
[[nodiscard]] std::vector<std::string> changed_files(const std::vector<FileDigest>& files,
                                                     const std::string& scenario);

/// Crosses the axes, drops the combinations that the rules exclude, and checks every combination that remains as a scenario. The order
/// is that of the file, the first axis changes slowest. Unless the sweep sets them, a run has no pictures, no
/// video, no `expect` and one thread.
/// `version` identifies the program. Throws InputError with everything that is wrong.
[[nodiscard]] SweepPlan plan_sweep(SweepConfig config, std::string version, const Registry& registry);

}  // namespace saccade
