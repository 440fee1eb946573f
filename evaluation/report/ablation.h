#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "evaluation/scoring/metrics.h"

namespace saccade {

/// A table for each scenario of which there are runs with several combinations of gaze controller, detector, its
/// window of events and gate: what each makes of the gaze, as mean and standard deviation over its runs, the best
/// value of each column marked. Runs that differ in other settings stand in tables of their own. The numbers go to
/// `out`/figures/ablation.csv. Empty, and no file, where there is nothing to compare. Throws RunError.
[[nodiscard]] std::string ablation_html(std::span<const Metrics* const> runs,
                                        const std::filesystem::path& out);

}  // namespace saccade
