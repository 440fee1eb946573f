#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// One drawing made of panels, as gnuplot text. Data travel inside the script and titles are quoted, so
/// nothing that a recording or a scenario holds can become a command.
class GnuplotFigure {
 public:
  GnuplotFigure(std::string_view name, int width, int height);

  /// One point; NaN in x or y makes a gap in a line.
  struct Point {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;  ///< only in 3D panels
  };
  struct Series {
    std::string title;          ///< in the key; none when empty
    std::string style;          ///< gnuplot's words after `with`
    std::vector<Point> points;  ///< thinned to max_figure_points
  };

  /// `commands` are gnuplot's `set` lines for this panel, from this program only, never from input.
  void add_panel(std::string_view commands, const std::vector<Series>& series, bool three_d = false);

  /// Draws. `layout` is what goes before the panels, such as `set multiplot layout 3,1`. Throws RunError.
  [[nodiscard]] std::string svg(std::string_view layout = "") const;

 private:
  std::string name_;
  std::string terminal_;
  std::string data_;
  std::string plots_;
  int blocks_ = 0;
};

/// A text as a gnuplot string that is drawn as it stands.
[[nodiscard]] std::string gnuplot_quoted(std::string_view text);

}  // namespace saccade
