#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "apps/view/layout.h"
#include "apps/view/snapshot.h"

namespace saccade {

/// A curve over the last Snapshot::plot_us.
struct PlotCurve {
  enum class Style {
    line,  ///< interrupted at NaN
    dots,
    mean,  ///< a line through the mean of each pixel column
  };
  std::string name;         ///< in the legend
  unsigned int colour = 0;  ///< ImU32
  Style style = Style::line;
  std::function<float(const PlotSample&)> value;  ///< NaN: no value
};

struct Plot {
  std::string title;  ///< with the unit
  double low = 0.0;   ///< of the axis; extended to the curves unless `fixed`
  double high = 1.0;
  bool fixed = false;
  bool downward = false;  ///< low at the top, as in an image
  std::vector<PlotCurve> curves;
};

/// Draws a plot: text into the current ImGui window, grid and curves into `canvas` (RGB), whose top left corner is at
/// `origin` in the window. (A software renderer draws thousands of short lines slowly.) Time runs from
/// now - Snapshot::plot_us to now; its labels count from the start.
void draw_plot(const Plot& plot, const Area& area, const Snapshot& snapshot, cv::Mat& canvas,
               const Area& origin);

}  // namespace saccade
