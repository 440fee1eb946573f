#pragma once

#include <filesystem>
#include <span>

namespace saccade {

/// Writes `out`/report.html over several runs and its numbers into `out`/figures. Runs of the same scenario
/// with the same settings make a group, whatever their seeds and detectors: mean and standard deviation over
/// them, precision-recall curves, detection rate over the ball's speed, average precision of all groups side
/// by side, where the gaze went (paper, Fig. 7), what controller, window and gate did to it, and a link to each run's
/// own report, which is written where it is missing.
/// Throws InputError naming every folder without a readable metrics.json and every one given twice, or a
/// broken table; RunError when a figure cannot be drawn or the disk does not take the page.
void write_comparison(std::span<const std::filesystem::path> runs, const std::filesystem::path& out);

}  // namespace saccade
