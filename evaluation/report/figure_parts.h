#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/units.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/report/palette.h"
#include "evaluation/scoring/scoring.h"

/// Styles and axes that several figures use.
namespace saccade::figure_parts {

using Point = GnuplotFigure::Point;
using Series = GnuplotFigure::Series;

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr Colour neutral_colour{0x55, 0x55, 0x55};
/// Of every figure, in the drawing's pixels.
inline constexpr int width = 900;

inline double seconds(std::int64_t t_us, std::int64_t start_us) {
  return static_cast<double>(t_us - start_us) * 1e-6;
}

template <class Rows, class Value>
std::vector<Point> over_time(const Rows& rows, std::int64_t start_us, Value value) {
  std::vector<Point> points;
  for (const auto& row : rows) points.push_back({.x = seconds(row.t_us, start_us), .y = value(row)});
  return points;
}

inline std::string line_style(std::string_view colour, double line_width = 1.6) {
  return fmt::format("lines lw {} lc rgb '{}'", line_width, colour);
}

inline std::string line_style(Colour colour, double line_width = 1.6) {
  return line_style(hex(colour), line_width);
}

inline std::string dot_style(Colour colour, double size = 0.3) {
  return fmt::format("points pt 7 ps {} lc rgb '{}'", size, hex(colour));
}

/// Panels one above the other with a common time axis under the last.
inline std::string stacked(int panels, double right = 0.985) {
  return fmt::format("set multiplot layout {},1 margins 0.095,{},{},{} spacing 0.0,0.035\n", panels, right,
                     panels > 2 ? 0.13 : 0.155, panels > 2 ? 0.94 : 0.97);
}

inline std::string time_range(double from_s, double to_s) {
  return to_s > from_s ? fmt::format("set xrange [{:.6g}:{:.6g}]\n", from_s, to_s) : std::string();
}

inline constexpr std::string_view time_label = "time [s]";

/// gnuplot's commands for a panel over time.
inline std::string axes(bool last, std::string_view y_range = "[*:*]") {
  return fmt::format(
      "set offsets 0, 0, graph 0.06, {}\nset yrange {}\n{}", y_range == "[*:*]" ? "graph 0.06" : "0", y_range,
      last ? "set xlabel offset 0,0.4\nset format x '%g'\n" : "unset xlabel\nset format x ''\n");
}

inline constexpr std::string_view precision_recall_axes =
    "set xrange [0:1]\nset yrange [0:1.03]\nset key outside right top\n";

inline std::vector<Point> curve_points(const DetectorScore& score) {
  std::vector<Point> points;
  for (const CurvePoint& p : score.pr_curve) points.push_back({p.recall, p.precision, p.threshold});
  return points;
}

inline std::string square_style(Colour colour) {
  return fmt::format("points pt 5 ps 1.1 lc rgb '{}'", hex(colour));
}

}  // namespace saccade::figure_parts
