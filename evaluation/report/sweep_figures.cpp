#include "evaluation/report/sweep_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/config.h"
#include "evaluation/report/figure_parts.h"
#include "evaluation/report/html.h"

namespace saccade::sweep {
namespace {

namespace fs = std::filesystem;
using figure_parts::dot_style;
using figure_parts::line_style;
using figure_parts::nan;
using figure_parts::Point;
using figure_parts::Series;

constexpr std::size_t most_curves = 8;
constexpr std::size_t most_maps = 12;

std::vector<GnuplotFigure::XWord> words_of(const Axis& axis) {
  std::vector<GnuplotFigure::XWord> words;
  if (axis.numeric) return words;
  for (const Bin& bin : axis.bins) words.push_back({bin.x, bin.label});
  return words;
}

/// gnuplot's commands for the x axis of one of `columns` panels side by side.
std::string x_axis_commands(const Axis& axis, std::size_t columns) {
  if (axis.numeric) {
    const double low = axis.bins.front().x;
    const double high = axis.bins.back().x;
    const double margin = 0.04;
    std::string commands =
        axis.log ? fmt::format("set logscale x\nset xrange [{:.6g}:{:.6g}]\n",
                               low * std::pow(high / low, -margin), high * std::pow(high / low, margin))
                 : fmt::format("unset logscale x\nset xrange [{:.6g}:{:.6g}]\n", low - margin * (high - low),
                               high + margin * (high - low));
    if (axis.binned) return commands + "set xtics auto\n";
    // A label for every value that does not run into the one before it.
    constexpr double label_share = 0.09;
    const auto place = [&](double x) {
      return axis.log ? std::log(x / low) / std::log(high / low) : (x - low) / (high - low);
    };
    std::string tics;
    double labelled = -1.0;
    for (const Bin& bin : axis.bins) {
      const bool fits = place(bin.x) - labelled >= label_share;
      tics += fmt::format("{}{} {:.10g}", tics.empty() ? "" : ", ",
                          gnuplot_quoted(fits ? short_number(bin.x) : ""), bin.x);
      if (fits) labelled = place(bin.x);
    }
    return commands + "set xtics (" + tics + ")\n";
  }
  // Words that would run into each other are drawn aslant.
  constexpr double letter_px = 8.0;
  std::size_t longest = 0;
  for (const Bin& bin : axis.bins) longest = std::max(longest, bin.label.size());
  const double place_px = 0.85 * figure_parts::width / static_cast<double>(columns * axis.bins.size());
  const bool aslant = letter_px * static_cast<double>(longest + 1) > place_px;
  return fmt::format("unset logscale x\nset xrange [-0.4:{}]\nset xtics {}\n", axis.bins.back().x + 0.4,
                     aslant ? "rotate by -30" : "norotate");
}

/// A metric of one detector over an axis: means, bars and, where values are many, the runs. `shift` keeps the bars of
/// several detectors apart where values are words.
std::vector<Series> metric_series(const Quantity::Of& of, const Axis& axis, const Facet& facet, Colour colour,
                                  double shift) {
  const std::string name = of.name.empty() ? std::string("mean") : of.name;
  // Words are not joined by a line.
  const char* lines = axis.numeric ? "linespoints lw 2 " : "points ";
  Series means{name, fmt::format("{}pt 7 ps 0.7 lc rgb '{}'", lines, hex(colour)), {}};
  Series bars{name + ", standard deviation", line_style(colour, 1.2), {}, false};
  Series runs{name + ", runs", dot_style(colour, 0.28), {}, false};
  for (const Bin& bin : axis.bins) {
    const Rows rows = intersection(bin.rows, facet.rows);
    const MeanSd mean = mean_of(rows, of.metric);
    if (!mean.mean) continue;
    const double x = bin.x + (axis.numeric ? 0.0 : shift);
    means.points.push_back({x, *mean.mean, 0.0});
    if (mean.sd) {
      bars.points.push_back({x, *mean.mean - *mean.sd, 0.0});
      bars.points.push_back({x, *mean.mean + *mean.sd, 0.0});
      bars.points.push_back({x, nan, nan});
    }
    if (!axis.binned) continue;
    for (const SweepRow* row : rows) {
      if (row->metrics[of.metric])
        runs.points.push_back({*number_of(row->values[axis.index]), *row->metrics[of.metric], 0.0});
    }
  }
  std::vector<Series> series;
  for (Series* s : {&runs, &bars, &means})
    if (!s->points.empty()) series.push_back(std::move(*s));
  return series;
}

/// How the panels of a figure lie, and the key: above several panels, beside a single one.
struct Layout {
  int height = 400;
  std::string multiplot;
  std::string key;  ///< commands of the first panel
};

std::size_t columns_of(std::size_t panels) { return panels == 1 ? 1 : panels == 2 || panels == 4 ? 2 : 3; }

/// The key names `series`, after `title` where there is one. (Inside a panel gnuplot draws it over the curves.)
Layout layout_of(std::size_t panels, const std::string& title, const std::vector<Series>& series) {
  if (panels == 1)
    return {.multiplot = "", .key = series.empty() ? "unset key\n" : "set key outside right top\n"};
  constexpr double letter_px = 8.0, mark_px = 30.0, row_px = 20.0, left_px = 60.0;
  struct Entry {
    std::string text, point;
    double x_px;
    int row;
  };
  std::vector<Entry> entries;
  double x_px = left_px;
  int row = 0;
  const auto add = [&](const std::string& text, const std::string& point) {
    const double width_px = letter_px * static_cast<double>(text.size()) + mark_px;
    if (x_px > left_px && x_px + width_px > figure_parts::width) {
      x_px = left_px;
      ++row;
    }
    entries.push_back({text, point, x_px, row});
    x_px += width_px;
  };
  if (!title.empty() && !series.empty()) add(title + ":", "");
  for (const Series& s : series)
    add(s.title, "point pt 5 ps 0.8 " + s.style.substr(s.style.find("lc rgb")) + " offset 1.3,0");

  const std::size_t columns = columns_of(panels);
  const std::size_t rows = (panels + columns - 1) / columns;
  const int key_rows = entries.empty() ? 0 : row + 1;
  Layout layout{.multiplot = "", .key = "unset key\n"};
  if (rows > 1) layout.height = static_cast<int>(330 * rows);
  layout.height += static_cast<int>(row_px) * key_rows;
  std::string space = "' '";  // as many lines of a title
  for (int i = 1; i < key_rows; ++i) space += ".\"\\n\".' '";
  layout.multiplot = fmt::format("set multiplot layout {},{}{}\n", rows, columns,
                                 key_rows > 0 ? " title " + space : std::string());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Entry& e = entries[i];
    layout.key += fmt::format("set label {} {} at screen {:.6g}, screen {:.6g} left {}\n", i + 1,
                              gnuplot_quoted(e.text), e.x_px / figure_parts::width,
                              1.0 - (12.0 + row_px * e.row) / layout.height, e.point);
  }
  return layout;
}

Colour colour_of(const Quantity::Of& of) {
  return of.name.empty() ? figure_parts::neutral_colour : detector_colour(of.name);
}

std::string numbers_of(const Quantity& quantity, const Axis& axis, const std::vector<Facet>& facets) {
  std::string csv = csv_field(axis.key) + ",others,detector,runs,mean,sd\n";
  for (const Facet& facet : facets) {
    for (const Quantity::Of& of : quantity.of) {
      for (const Bin& bin : axis.bins) {
        const MeanSd mean = mean_of(intersection(bin.rows, facet.rows), of.metric);
        csv += fmt::format("{},{},{},{},{},{}\n", csv_field(bin.label), csv_field(facet.label),
                           csv_field(of.name), mean.count, mean.mean ? text_of(*mean.mean) : "",
                           mean.sd ? text_of(*mean.sd) : "");
      }
    }
  }
  return csv;
}

}  // namespace

std::string sweep_curves_html(const Quantity& quantity, const Axis& axis, const std::vector<Axis>& axes,
                              const Rows& rows, const FigureFolder& folder) {
  const std::vector<Facet> facets = facets_of(axes, axis, rows);
  std::vector<Series> named;
  for (const Quantity::Of& of : quantity.of)
    named.push_back({.title = of.name, .style = line_style(colour_of(of)), .points = {}});
  const Layout layout = layout_of(facets.size(), "", named.size() > 1 ? named : std::vector<Series>());
  const std::string name = file_part(quantity.label + "_over_" + axis.key);
  // The same scale in all panels.
  double low = nan;
  double high = nan;
  for (const SweepRow* row : rows) {
    for (const Quantity::Of& of : quantity.of) {
      if (!row->metrics[of.metric]) continue;
      low = std::fmin(low, *row->metrics[of.metric]);
      high = std::fmax(high, *row->metrics[of.metric]);
    }
  }
  if (!std::isfinite(low)) return {};
  if (low >= 0.0) low = 0.0;
  if (high <= low) high = low + 1.0;
  GnuplotFigure figure(name, figure_parts::width, layout.height);
  figure.set_over_x();
  for (std::size_t f = 0; f < facets.size(); ++f) {
    std::vector<Series> series;
    for (std::size_t i = 0; i < quantity.of.size(); ++i) {
      const Quantity::Of& of = quantity.of[i];
      const double shift =
          0.08 * (static_cast<double>(i) - 0.5 * static_cast<double>(quantity.of.size() - 1));
      for (Series& s : metric_series(of, axis, facets[f], colour_of(of), shift))
        series.push_back(std::move(s));
    }
    figure.add_panel(
        {.x_label = axis.key,
         .y_label = quantity.label,
         .z_label = {},
         .commands = x_axis_commands(axis, columns_of(facets.size())) +
                     fmt::format("set yrange [{:.6g}:{:.6g}]\n", low, high + 0.06 * (high - low)) +
                     (f == 0 ? layout.key : std::string("unset label\n")),
         .series = std::move(series),
         .title = facets[f].label,
         .x_words = words_of(axis)});
  }
  Figure drawn = figure.draw(layout.multiplot);
  drawn.csv = numbers_of(quantity, axis, facets);
  const std::string reading = fmt::format(
      "The mean over {}; a bar reaches one standard deviation to both sides.{}",
      facets.size() == 1 && axes.size() > 1 ? "all else that is varied, seeds included" : "the seeds",
      axis.binned ? " Dots are runs; the line joins the means of equal intervals." : "");
  return figure_html(quantity.label + " over " + axis.key, reading, drawn, folder);
}

namespace {

/// From dark blue over green to yellow, 0 to 1 (after viridis, which colour-blind readers can read).
Colour map_colour(double share) {
  constexpr std::array<std::array<double, 3>, 5> anchors = {
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double place = std::clamp(share, 0.0, 1.0) * (anchors.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(place), anchors.size() - 2);
  const double t = place - static_cast<double>(i);
  const auto channel = [&](std::size_t k) {
    return static_cast<std::uint8_t>(std::lround(anchors[i][k] * (1.0 - t) + anchors[i + 1][k] * t));
  };
  return {channel(0), channel(1), channel(2)};
}

/// A metric over two axes, the mean over all else.
std::string map_html(const std::string& title, std::size_t metric, const Axis& across, const Axis& down,
                     const FigureFolder& folder) {
  std::vector<std::vector<MeanSd>> cells;
  double low = nan;
  double high = nan;
  for (const Bin& row : down.bins) {
    cells.emplace_back();
    for (const Bin& column : across.bins) {
      cells.back().push_back(mean_of(intersection(row.rows, column.rows), metric));
      const auto& mean = cells.back().back().mean;
      if (!mean) continue;
      low = std::fmin(low, *mean);
      high = std::fmax(high, *mean);
    }
  }
  if (!std::isfinite(low)) return {};
  std::string csv = csv_field(down.key) + "," + csv_field(across.key) + ",runs,mean,sd\n";
  std::string html = fmt::format("<div class=\"wide\"><table class=\"map\"><thead><tr><th>{} \\ {}</th>",
                                 escaped(down.key), escaped(across.key));
  for (const Bin& column : across.bins) html += "<th>" + escaped(column.label) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (std::size_t r = 0; r < down.bins.size(); ++r) {
    html += "<tr><th>" + escaped(down.bins[r].label) + "</th>";
    for (std::size_t c = 0; c < across.bins.size(); ++c) {
      const MeanSd& cell = cells[r][c];
      csv += fmt::format("{},{},{},{},{}\n", csv_field(down.bins[r].label), csv_field(across.bins[c].label),
                         cell.count, cell.mean ? text_of(*cell.mean) : "", cell.sd ? text_of(*cell.sd) : "");
      if (!cell.mean) {
        html += "<td class=\"none\">–</td>";
        continue;
      }
      const double share = high > low ? (*cell.mean - low) / (high - low) : 0.5;
      html +=
          fmt::format("<td data-value=\"{}\" style=\"background:{};color:{}\">{}</td>", text_of(*cell.mean),
                      hex(map_colour(share)), share < 0.55 ? "#fff" : "#111", short_number(*cell.mean));
    }
    html += "</tr>\n";
  }
  html += "</tbody></table></div>\n";
  const std::string name = file_part("map_" + title + "_" + across.key + "_" + down.key);
  write_numbers(folder.page, name, csv);
  return figure_html(
      title + " over " + across.key + " and " + down.key,
      fmt::format("The mean over seeds and all else that is varied, from {} (dark) to {} (bright). "
                  "<a href=\"figures/{}.csv\">Numbers</a>",
                  short_number(low), short_number(high), name),
      html);
}

}  // namespace

std::string sweep_maps_html(const SweepTable& table, const std::vector<Axis>& axes,
                            const FigureFolder& folder) {
  std::string html;
  std::size_t count = 0;
  for (const Quantity& quantity : quantities_of(table)) {
    for (const Quantity::Of& of : quantity.of) {
      for (std::size_t a = 0; a < axes.size(); ++a) {
        for (std::size_t b = a + 1; b < axes.size(); ++b) {
          if (count++ >= most_maps) continue;
          const std::string title = quantity.label + (of.name.empty() ? "" : " of " + of.name);
          const bool a_is_longer = axes[a].bins.size() >= axes[b].bins.size();
          html += map_html(title, of.metric, axes[a_is_longer ? a : b], axes[a_is_longer ? b : a], folder);
        }
      }
    }
  }
  return html;
}

namespace {

/// The precision at the highest threshold whose recall reaches that; none where none does.
std::optional<double> precision_at(const std::vector<CurvePoint>& curve, double recall) {
  const CurvePoint* best = nullptr;
  for (const CurvePoint& point : curve)
    if (point.recall >= recall && (best == nullptr || point.threshold > best->threshold)) best = &point;
  return best != nullptr ? std::optional(best->precision) : std::nullopt;
}

/// The mean precision of a detector at each recall that all of the runs reach.
std::vector<Point> mean_curve(const Rows& rows, const std::string& detector) {
  constexpr int steps = 50;
  std::vector<Point> points;
  for (int i = 1; i <= steps; ++i) {
    const double recall = static_cast<double>(i) / steps;
    double sum = 0.0;
    double count = 0.0;
    for (const SweepRow* row : rows) {
      for (const auto& [name, curve] : row->curves) {
        if (name != detector) continue;
        const auto precision = precision_at(curve, recall);
        if (!precision) return points;
        sum += *precision;
        count += 1.0;
      }
    }
    if (count == 0.0) return points;
    points.push_back({recall, sum / count, 0.0});
  }
  return points;
}

}  // namespace

std::string sweep_precision_recall_html(const Axis& axis, const std::vector<std::string>& detectors,
                                        const FigureFolder& folder) {
  if (axis.bins.size() > most_curves) return {};
  std::vector<GnuplotFigure::Panel> panels;
  std::vector<Series> named;
  for (const std::string& detector : detectors) {
    std::vector<Series> series;
    for (std::size_t i = 0; i < axis.bins.size(); ++i) {
      constexpr double brightest = 0.85;  // yellow does not show on white
      const double share = brightest * static_cast<double>(i) / static_cast<double>(axis.bins.size() - 1);
      std::vector<Point> points = mean_curve(axis.bins[i].rows, detector);
      if (points.empty()) continue;
      series.push_back({axis.bins[i].label, line_style(map_colour(share), 2.0), std::move(points)});
    }
    if (series.empty() || panels.size() == most_panels) continue;
    if (series.size() > named.size()) {
      named = series;
      for (Series& s : named) s.points.clear();
    }
    panels.push_back({.x_label = "recall",
                      .y_label = "precision",
                      .z_label = {},
                      .commands = "set xrange [0:1.01]\nset yrange [0:1.03]\n",
                      .series = std::move(series),
                      .title = detector});
  }
  if (panels.empty()) return {};
  if (panels.size() == 1) panels.front().title += ", by " + axis.key;
  const Layout layout = layout_of(panels.size(), axis.key, named);
  panels.front().commands += layout.key;
  for (std::size_t i = 1; i < panels.size(); ++i) panels[i].commands += "unset label\n";
  GnuplotFigure figure(file_part("precision_recall_" + axis.key), figure_parts::width, layout.height);
  figure.set_over_x();
  for (GnuplotFigure::Panel& panel : panels) figure.add_panel(std::move(panel));
  return figure_html(
      "Precision and recall over " + axis.key,
      "A line for each value: the mean of the runs' precision at each recall, as far as all of them "
      "reach it. The further up and right, the better.",
      figure.draw(layout.multiplot), folder);
}

}  // namespace saccade::sweep
