#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// A drawing and the numbers in it. `csv`: one row per point, the series' name, the x axis and one column per
/// panel, headed by the labels of the axes; empty where a panel has no value. Nothing is thinned there.
struct Figure {
  std::string name;  ///< unique within a page: it prefixes the ids inside the SVG and names the CSV file
  std::string svg;   ///< a stand-alone text
  std::string csv;
  /// The drawing's numbers for the plots of a page, as JSON: name, x_label, over_x, panels of {title, y_label, x_range,
  /// y_range, log_x, x_words, bands, series of {title, colour, width, dashed, lines, points, in_key, x, y}}; null in y is a
  /// gap. Thinned as the drawing is.
  std::string data;
  std::string script;            ///< gnuplot's text without `set terminal`, to draw it once more
  std::vector<std::string> key;  ///< of the first panel: the titles of the series that a key names
  std::size_t panels = 1;
  double height_share = 0.5;  ///< height over width of the drawing
};

/// One drawing made of panels, as gnuplot text. Data travel inside the script and titles are quoted, so
/// nothing that a recording or a scenario holds can become a command.
class GnuplotFigure {
 public:
  /// Sizes of the page's drawing; another drawing of the script has its own, and small_font in the same ratio.
  static constexpr int font = 13;
  static constexpr int small_font = 11;  ///< of titles

  GnuplotFigure(std::string_view name, int width, int height);

  /// One point; NaN in x or y makes a gap in a line.
  struct Point {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;  ///< a number beside the point, not drawn, where z_label is set
  };
  struct Series {
    std::string title;
    std::string style;          ///< gnuplot's words after `with`
    std::vector<Point> points;  ///< thinned to max_figure_points in the drawing
    bool in_key = true;
  };
  struct XWord {
    double x = 0.0;
    std::string word;
  };
  struct Panel {
    std::string x_label;  ///< the same in all panels of a figure
    std::string y_label;
    std::string z_label;
    /// gnuplot's `set` lines for this panel, after the labels; from this program only, never from input.
    std::string commands;
    std::vector<Series> series;
    std::vector<std::array<double, 2>> bands = {};  ///< intervals of x shaded in a page's plot
    std::string title = {};                         ///< above the panel; empty: none
    std::vector<XWord> x_words = {};                ///< where x stands for words: all labels of the axis
  };

  void add_panel(Panel panel) { panels_.push_back(std::move(panel)); }
  /// Each series is a function of x, its points in the order of x: a page can zoom along x.
  void set_over_x() { over_x_ = true; }

  /// `layout` is what goes before the panels, such as `set multiplot layout 3,1`. Without gnuplot the drawing
  /// says so. Throws RunError where gnuplot fails.
  [[nodiscard]] Figure draw(std::string_view layout = "") const;

 private:
  [[nodiscard]] std::string script(std::string_view layout) const;
  [[nodiscard]] std::string csv() const;
  [[nodiscard]] std::string data() const;

  std::string name_;
  int width_;
  int height_;
  bool over_x_ = false;
  std::vector<Panel> panels_;
};

/// A text as a gnuplot string that is drawn as it stands.
[[nodiscard]] std::string gnuplot_quoted(std::string_view text);

/// A text as one field of a CSV line: in quotes where it holds a comma, a quote or a line break.
[[nodiscard]] std::string csv_field(std::string_view text);

/// A name as a part of a file's name: letters, digits, '-' and '_' stay, what else there is becomes '_'.
[[nodiscard]] std::string file_part(std::string_view name);

}  // namespace saccade
