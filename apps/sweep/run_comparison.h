#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/sweep/run_sets.h"
#include "evaluation/scoring/statistics.h"

namespace saccade::inline v0_1 {

/// How far a figure may change: `--tolerance KEY=VALUE`.
struct Tolerance {
  std::string key;        ///< path of a figure; `*` stands for any characters
  double value = 0.0;     ///< largest difference of the means that counts as equal
  bool relative = false;  ///< of the figure's mean in A
};

/// Reads "KEY=VALUE" or "KEY=VALUE%". Throws InputError.
[[nodiscard]] Tolerance tolerance_of(const std::string& text);

/// One figure on both sides.
struct ComparedFigure {
  std::string name;
  MeanSd a;
  MeanSd b;
  double tolerance = 0.0;
  std::optional<double> p_value;  ///< none: one side has fewer than two values
  bool changed = false;
};

/// The runs of one label on both sides; of one that is on one side alone `figures` is empty.
struct ComparedSet {
  std::string label;
  std::vector<std::string> seeds_a;
  std::vector<std::string> seeds_b;
  std::string configuration = {};  ///< keys of B that differ from A; empty where none does
  std::vector<ComparedFigure> figures = {};
};

struct RunComparison {
  RunSet a;
  RunSet b;
  std::vector<ComparedSet> sets;
  [[nodiscard]] bool different() const;
};

/// Compares two sides. Runs of the same label belong together; where each side has one group they do, whatever the labels.
/// A figure has changed if the means over seeds differ by more than its tolerance (0 without one; the last one given that
/// fits) and, where both sides have two values or more, Welch's t test gives p < 0.01; or if it applies on one side alone.
[[nodiscard]] RunComparison compare(RunSet a, RunSet b, const std::vector<Tolerance>& tolerances);

/// Versions, counts, the rule, and the figures that have changed, for a terminal.
[[nodiscard]] std::string comparison_text(const RunComparison& comparison);
/// All figures, changed or not.
[[nodiscard]] std::string comparison_json(const RunComparison& comparison);

}  // namespace saccade::inline v0_1
