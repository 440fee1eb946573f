#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "evaluation/report/resolved_scenario.h"
#include "evaluation/scoring/metrics.h"

namespace saccade {

struct AblationRun {
  const Metrics* metrics = nullptr;
  ResolvedKeys keys;  ///< empty where they were not recorded
};

/// A table for each scenario of which there are runs with several combinations of gaze controller, detector, its
/// window of events and gate: the gaze's figures as mean and standard deviation over the runs of each combination, the
/// best value of each column marked. Runs that differ in other settings are in tables of their own. The numbers go to
/// `out`/figures/ablation.csv. Empty, and no file, where there is nothing to compare. Throws RunError.
[[nodiscard]] std::string ablation_html(std::span<const AblationRun> runs, const std::filesystem::path& out);

}  // namespace saccade
