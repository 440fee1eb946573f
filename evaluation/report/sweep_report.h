#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/scoring/scoring.h"

namespace saccade {

/// One run of a sweep.
struct SweepRow {
  std::int64_t run = 0;
  std::string id;
  std::string status;  ///< waiting, done, failed
  std::string failure;
  std::vector<std::string> values;                                      ///< of each axis
  std::vector<std::optional<double>> metrics;                           ///< of each of the report's
  std::vector<std::pair<std::string, std::vector<CurvePoint>>> curves;  ///< by detector
};

/// The table of a sweep.
struct SweepTable {
  std::string name;
  std::string description;
  std::string scenario;
  std::string version;
  std::vector<std::string> axes;     ///< means and deviations are over the axis `seed`
  std::vector<std::string> metrics;  ///< the main one first
  std::size_t worst = 0;             ///< how many runs count as the worst
  bool lowest_is_worst = true;       ///< by the main metric
  std::vector<SweepRow> rows;
};

/// The runs with the worst main metric, the worst first; of identical runs the first one. Runs without the metric are left
/// out.
[[nodiscard]] std::vector<const SweepRow*> worst_runs(const SweepTable& table);

/// Writes `folder`/report.html and the numbers of its figures: each metric over each axis as mean and standard deviation,
/// maps over pairs of axes, precision and recall, the worst runs with links to worst/ID/report.html where that exists,
/// and the failed ones. `figures`: FigureFolder::paper. Throws RunError.
void write_sweep_report(const SweepTable& table, const std::filesystem::path& folder,
                        const std::filesystem::path& figures = {});

}  // namespace saccade
