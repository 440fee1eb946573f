#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/report/gnuplot.h"

/// What the figures have in common: styles, axes over time.
namespace saccade::figure_parts {

using Point = GnuplotFigure::Point;
using Series = GnuplotFigure::Series;

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double deg_per_rad = 180.0 / std::numbers::pi;
inline constexpr std::string_view truth_style = "lines lw 1.4 lc rgb '#222222'";
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

inline std::string dot_style(std::string_view colour, double size = 0.3) {
  return fmt::format("points pt 7 ps {} lc rgb '{}'", size, colour);
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

/// What a panel over time needs beside its labels.
inline std::string axes(bool last, std::string_view y_range = "[*:*]") {
  return fmt::format(
      "set offsets 0, 0, graph 0.06, {}\nset yrange {}\n{}", y_range == "[*:*]" ? "graph 0.06" : "0", y_range,
      last ? "set xlabel offset 0,0.4\nset format x '%g'\n" : "unset xlabel\nset format x ''\n");
}

}  // namespace saccade::figure_parts
