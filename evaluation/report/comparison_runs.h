#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "evaluation/report/figures.h"
#include "evaluation/report/resolved_scenario.h"
#include "evaluation/scoring/metrics.h"
#include "recording/run_files.h"

namespace saccade {

/// The runs of a comparison and how they are grouped.

struct ComparedRun {
  std::filesystem::path folder;
  Metrics metrics;
  ResolvedKeys keys;  ///< empty where the folder has no resolved configuration
};

/// Runs that differ in their seeds alone, and the scores of each detector in them.
struct ComparedGroup {
  std::string label;
  std::vector<const ComparedRun*> runs;
  std::vector<DetectorRuns> detectors;
  std::vector<DetectorSpeeds> speeds;
  /// Runs that repeat a run of the group, seed included, and interrupted runs beside whole ones; they are in none of the
  /// figures and tables. One sentence each, plain text.
  std::vector<std::string> duplicates;
};

/// Throws InputError naming every folder without a readable metrics.json and every one given twice.
[[nodiscard]] std::vector<ComparedRun> load_runs(std::span<const std::filesystem::path> folders);

/// Groups in the order of their first runs, those of interrupted runs alone last. Runs belong together when their resolved configurations are equal but for
/// the seed; runs without one (of old versions) when scenario and settings are equal. Throws InputError for a broken
/// table.
[[nodiscard]] std::vector<ComparedGroup> grouped(const std::vector<ComparedRun>& runs);

/// "key=value, ..." of a run's settings.
[[nodiscard]] std::string settings_text(const Metrics& metrics);
/// The seed; empty where there is none.
[[nodiscard]] std::string seed_text(const Metrics& metrics);
/// Truth every millisecond, as a simulation writes it; empty where the run has none.
[[nodiscard]] std::vector<TruthRow> dense_truth(const ComparedRun& run);

}  // namespace saccade
