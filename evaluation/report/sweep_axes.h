#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/report/sweep_report.h"
#include "evaluation/scoring/statistics.h"

namespace saccade::sweep {

/// How the runs of a sweep are sorted for its report: axes with their values, metrics by detector, panels.

inline constexpr std::string_view seed_axis = "seed";
inline constexpr std::size_t most_panels = 6;
inline constexpr std::size_t most_values =
    20;  ///< of an axis that is drawn value by value; more are put into bins

/// One value of an axis, or an interval of an axis with many values.
struct Bin {
  std::string label;
  double x =
      0.0;  ///< on the drawn axis: the value or the interval's middle; the index where values are words
  std::vector<const SweepRow*> rows;
};

/// An axis with more than one value in the finished runs.
struct Axis {
  std::size_t index = 0;
  std::string key;
  bool numeric = false;
  bool log = false;  ///< values cover a wide range
  bool binned = false;
  std::vector<Bin> bins;
};

using Rows = std::vector<const SweepRow*>;

/// One metric of several detectors, or a metric that belongs to none.
struct Quantity {
  std::string label;
  struct Of {
    std::string name;  ///< the detector; empty for a metric that belongs to none
    std::size_t metric = 0;
  };
  std::vector<Of> of;
};

/// Runs that are shown together.
struct Facet {
  std::string label;
  Rows rows;
};

/// The whole text as a number; none for words.
[[nodiscard]] std::optional<double> number_of(const std::string& text);
[[nodiscard]] Rows done_rows(const SweepTable& table);
[[nodiscard]] std::vector<Axis> axes_of(const SweepTable& table, const Rows& rows);
[[nodiscard]] std::vector<Quantity> quantities_of(const SweepTable& table);
/// "detectors.best.recall" is the recall (`label`) of best.
[[nodiscard]] Quantity::Of detector_of(const std::string& metric, std::size_t index, std::string& label);
/// The names of all detectors in metrics and curves.
[[nodiscard]] std::vector<std::string> detectors_of(const SweepTable& table);
[[nodiscard]] MeanSd mean_of(const Rows& rows, std::size_t metric);
[[nodiscard]] Rows intersection(const Rows& a, const Rows& b);
/// The combinations of all axes but `shown`, where they are few; otherwise all runs together.
[[nodiscard]] std::vector<Facet> facets_of(const std::vector<Axis>& axes, const Axis& shown,
                                           const Rows& rows);
/// True for an axis of words whose values are the panels of the figures over an axis of numbers.
[[nodiscard]] bool is_shown_by_panels(const Axis& axis, const std::vector<Axis>& axes, const Rows& rows);

}  // namespace saccade::sweep
