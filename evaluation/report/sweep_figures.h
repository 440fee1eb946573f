#pragma once

#include <string>
#include <vector>

#include "evaluation/report/html.h"
#include "evaluation/report/sweep_axes.h"

namespace saccade::sweep {

/// The figures of a sweep's report, as HTML; empty where there is nothing to show. Their numbers go to
/// `folder`/figures. `detectors` from detectors_of(). Throw RunError.

/// A metric over one axis, a panel for each combination of the others: means, bars of one standard deviation.
[[nodiscard]] std::string sweep_curves_html(const Quantity& quantity, const Axis& axis,
                                            const std::vector<Axis>& axes, const Rows& rows,
                                            const FigureFolder& folder);
/// Every metric over each pair of axes as a table of coloured cells.
[[nodiscard]] std::string sweep_maps_html(const SweepTable& table, const std::vector<Axis>& axes,
                                          const FigureFolder& folder);
/// Mean precision over recall, a line for each value of the axis and a panel for each detector.
[[nodiscard]] std::string sweep_precision_recall_html(const Axis& axis,
                                                      const std::vector<std::string>& detectors,
                                                      const FigureFolder& folder);

}  // namespace saccade::sweep
