#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "apps/view/layout.h"
#include "apps/view/picture.h"

namespace saccade {

/// A curve of a plot over the last Picture::plot_us.
struct PlotCurve {
  enum class Style {
    line,  ///< broken where there is nothing
    dots,
    mean,  ///< a line through the mean over the time that a pixel stands for
  };
  std::string name;         ///< in the plot's legend; empty: not in it
  unsigned int colour = 0;  ///< ImU32
  Style style = Style::line;
  std::function<float(const PlotSample&)> value;  ///< NaN: nothing
};

struct Plot {
  std::string title;  ///< with the unit
  double low = 0.0;   ///< of the axis; wider where a curve leaves it and `fixed` is not set
  double high = 1.0;
  bool fixed = false;
  bool downward = false;  ///< low is at the top, as in an image
  std::vector<PlotCurve> curves;
};

/// Draws words into the current ImGui window, and paper, grid and curves into `canvas` (RGB), whose top left corner is
/// at `origin` in the window: thousands of short lines would cost a software renderer more than everything else.
/// Time runs from now - Picture::plot_us to now, its labels from the start.
void draw_plot(const Plot& plot, const Area& area, const Picture& picture, cv::Mat& canvas,
               const Area& origin);

}  // namespace saccade
