#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/report/comparison_runs.h"

namespace saccade {

/// The tables of a comparison: means and standard deviations over the runs of a group.

/// As HTML; `number` makes their ids unique. The second is empty where no run has a gaze.
[[nodiscard]] std::string compared_detectors_table(const ComparedGroup& group, std::size_t number);
[[nodiscard]] std::string compared_gaze_table(const ComparedGroup& group, std::size_t number);

/// Writes figures/runs.csv, means.csv and gaze_means.csv into `out`. Throws RunError.
void write_comparison_tables(const std::vector<ComparedGroup>& groups, const std::filesystem::path& out);

}  // namespace saccade
