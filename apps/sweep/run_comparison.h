#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/sweep/run_sets.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {

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
  /// Of the paired t test where the set is paired and the figure applies in all its runs, otherwise of Welch's t test; none
  /// where one side has fewer than two values.
  std::optional<double> p_value;
  bool changed = false;
};

/// The runs of one label on both sides; of one that is on one side alone `figures` is empty.
struct ComparedSet {
  std::string label;
  std::vector<std::string> seeds_a;
  std::vector<std::string> seeds_b;
  bool paired = false;             ///< compared seed by seed
  std::string configuration = {};  ///< keys of B that differ from A; empty where none does
  std::vector<ComparedFigure> figures = {};
};

struct RunComparison {
  RunSet a;
  RunSet b;
  std::vector<ComparedSet> sets;
  /// Also where a side has runs without a result: of them nothing is known.
  [[nodiscard]] bool different() const;
};

/// Compares two sides. Runs of the same label belong together; where each side has one group they do, whatever the labels.
/// A figure has changed if the means over seeds differ by more than its tolerance (0 without one; the last one given that
/// fits) and, where both sides have two values or more, the t test gives p < 0.01; or if it applies on one side alone. The
/// t test is Welch's, of the spread over seeds; with `paired`, in sets whose sides have the same seeds, the paired one, of
/// the spread of the differences from seed to seed. Throws InputError for a tolerance that fits no figure of either side.
[[nodiscard]] RunComparison compare(RunSet a, RunSet b, const std::vector<Tolerance>& tolerances,
                                    bool paired = false);

/// When a figure counts as changed, in words.
inline constexpr std::string_view comparison_rule =
    "A figure has changed if the means over seeds differ by more than its tolerance and, with two seeds or "
    "more on both sides, the t test gives p < 0.01.";
/// Of sides that were simulated with versions of MuJoCo of different ranges; else empty.
[[nodiscard]] std::string comparison_warning(const RunComparison& comparison);

/// Versions, counts, the rule, and the figures that have changed, for a terminal.
[[nodiscard]] std::string comparison_text(const RunComparison& comparison);
/// All figures, changed or not.
[[nodiscard]] std::string comparison_json(const RunComparison& comparison);

}  // namespace saccade
