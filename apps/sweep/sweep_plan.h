#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/registry.h"
#include "apps/sweep/sweep_config.h"

namespace saccade::inline v0_1 {

/// One combination of values.
struct PlannedRun {
  /// A digest of scenario, seed and version; equal for combinations that give the same run.
  std::string id;
  std::vector<std::size_t> values;  ///< for each axis the index of its value
  std::int64_t seed = 0;
  std::string scenario;  ///< with every default, as `saccade run` takes it
};

/// All runs of a sweep, in the order of its tables.
struct SweepPlan {
  SweepConfig config;
  std::string version;
  std::vector<std::string> metrics;  ///< that the report shows, the main one first
  std::vector<PlannedRun> runs;
};

/// Crosses the axes, drops the combinations that the rules exclude, and checks every combination that remains as a scenario. The order
/// is that of the file, the first axis changes slowest. Unless the sweep sets them, a run has no pictures, no
/// video, no `expect` and one thread.
/// `version` identifies the program. Throws InputError with everything that is wrong.
[[nodiscard]] SweepPlan plan_sweep(SweepConfig config, std::string version, const Registry& registry);

/// 16 hexadecimal digits that stand for the bytes (FNV-1a, 64 bits).
[[nodiscard]] std::string digest(std::string_view bytes);

}  // namespace saccade::inline v0_1
