#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/sweep/benchmark_list.h"
#include "apps/sweep/sweep_engine.h"
#include "apps/sweep/sweep_plan.h"
#include "config/registry.h"
#include "config/yaml_tree.h"

namespace saccade {

/// A detector that takes part.
struct BenchmarkEntry {
  std::string name;
  YamlNode detectors;  ///< block `detectors` of a scenario, with this one
  std::string place;   ///< for messages
  std::string latency_class = {};
};

/// In a world an entry runs twice: with the latencies of the list under this name, for its streaming score, and without
/// any under its own, for all other figures. So that slow detectors process every event at its time in the latter.
[[nodiscard]] std::string with_latency(const std::string& entry);

/// The class of an entry: `stated`, or its preset. Empty for a list without latencies. Throws InputError for one that the list does not have.
[[nodiscard]] std::string latency_class_of(const BenchmarkEntry& entry, const BenchmarkList& list,
                                           const std::string& stated, const Registry& registry);

/// Of the class with that name.
[[nodiscard]] WorkTime work_of(const BenchmarkLatency& latency, std::string_view name);

/// A value in a tree.
[[nodiscard]] YamlNode yaml_scalar(const std::string& text);

/// A part of a list and the runs of an entry in it.
struct PlannedPart {
  BenchmarkPart part;
  SweepPlan plan;
};

/// The runs of an entry, all checked. Throws InputError.
[[nodiscard]] std::vector<PlannedPart> plan_entry(std::vector<BenchmarkPart> parts,
                                                  const BenchmarkEntry& entry, const BenchmarkList& list,
                                                  const std::string& version, const Registry& registry);

/// An entry with its runs and the folder of its results.
struct PlannedEntry {
  BenchmarkEntry entry;
  std::vector<PlannedPart> parts;
  std::filesystem::path folder;
};

/// Runs each world once for all the entries that have no result of it, and writes the result of each entry into its folder,
/// as if it had run alone. Worlds that one entry lacks, and those that fail, are left to the entry's own sweep. `folder`: of the runs. Throws as make_sweep().
void make_worlds(const std::vector<PlannedEntry>& entries, const BenchmarkList& list,
                 const std::filesystem::path& folder, const SweepEngineConfig& engine, bool retry,
                 const std::string& version, const Registry& registry);

}  // namespace saccade
