#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace saccade {

class FormatRegistry;

/// Writes `out`/report.html over several runs and its numbers into `out`/figures. Runs that differ in their seeds alone
/// make a group (see grouped()): mean and standard deviation over them, precision-recall curves, detection rate over the
/// ball's speed, average precision of all groups side by side, the gaze (paper, Fig. 7), an ablation over controller,
/// window and gate, and a link to each run's own report, which is written where it is missing. `formats`: of the runs' event files. `figures`: FigureFolder::paper.
/// Returns a sentence for each run that repeats another one, seed included, and was therefore not counted, and a warning
/// where runs were simulated with versions of MuJoCo of different ranges.
/// Throws InputError naming every folder without a readable metrics.json and every one given twice, or a
/// broken table; RunError when a figure cannot be drawn or the page cannot be written.
std::vector<std::string> write_comparison(std::span<const std::filesystem::path> runs,
                                          const std::filesystem::path& out, const FormatRegistry& formats,
                                          const std::filesystem::path& figures = {});

}  // namespace saccade
