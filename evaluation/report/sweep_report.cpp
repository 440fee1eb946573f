#include "evaluation/report/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <span>

#include "core/config.h"
#include "evaluation/report/figure_parts.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/html.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using figure_parts::dot_style;
using figure_parts::line_style;
using figure_parts::nan;
using figure_parts::Point;
using figure_parts::Series;

constexpr std::string_view seed_axis = "seed";
constexpr std::size_t most_panels = 6;
constexpr std::size_t most_values = 20;  ///< of an axis that is drawn value by value; more are put into bins
constexpr std::size_t bin_count = 8;
constexpr std::size_t most_curves = 8;
constexpr std::size_t most_maps = 12;
constexpr std::size_t most_table_rows = 100;
constexpr std::size_t most_failures = 50;

std::optional<double> number_of(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole ? std::optional(value) : std::nullopt;
}

/// The values of an axis that stand together: one value, or a stretch of an axis with many.
struct Bin {
  std::string label;
  double x = 0.0;  ///< where it is drawn: its value or the middle, or its number where values are words
  std::vector<const SweepRow*> rows;
};

/// An axis that has more than one value in the runs that are done.
struct Axis {
  std::size_t index = 0;
  std::string key;
  bool numeric = false;
  bool log = false;  ///< values spread over a wide range
  bool binned = false;
  std::vector<Bin> bins;
};

using Rows = std::vector<const SweepRow*>;

Rows done_rows(const SweepTable& table) {
  Rows rows;
  for (const SweepRow& row : table.rows)
    if (row.status == "done") rows.push_back(&row);
  return rows;
}

void put_into_bins(Axis& axis, const Rows& rows, const std::vector<double>& sorted) {
  axis.binned = true;
  const auto scale = [&](double value) { return axis.log ? std::log(value) : value; };
  const auto unscale = [&](double value) { return axis.log ? std::exp(value) : value; };
  const double low = scale(sorted.front());
  const double step = (scale(sorted.back()) - low) / static_cast<double>(bin_count);
  for (std::size_t i = 0; i < bin_count; ++i) {
    const double from = low + step * static_cast<double>(i);
    axis.bins.push_back({short_number(unscale(from)) + " to " + short_number(unscale(from + step)),
                         unscale(from + 0.5 * step),
                         {}});
  }
  for (const SweepRow* row : rows) {
    const double place = (scale(*number_of(row->values[axis.index])) - low) / step;
    const auto bin = std::min(static_cast<std::size_t>(std::max(place, 0.0)), bin_count - 1);
    axis.bins[bin].rows.push_back(row);
  }
}

std::vector<Axis> axes_of(const SweepTable& table, const Rows& rows) {
  constexpr double wide = 7.9;  // from one end to the other
  std::vector<Axis> axes;
  for (std::size_t i = 0; i < table.axes.size(); ++i) {
    if (table.axes[i] == seed_axis) continue;
    Axis axis{i, table.axes[i], true, false, false, {}};
    std::vector<std::string> texts;  // in the order of the plan
    std::vector<double> numbers;
    for (const SweepRow* row : rows) {
      const std::string& text = row->values[i];
      if (std::find(texts.begin(), texts.end(), text) != texts.end()) continue;
      texts.push_back(text);
      const auto number = number_of(text);
      axis.numeric &= number.has_value();
      numbers.push_back(number.value_or(0.0));
    }
    if (texts.size() < 2) continue;
    std::vector<double> sorted = numbers;
    std::sort(sorted.begin(), sorted.end());
    axis.log = axis.numeric && sorted.front() > 0.0 && sorted.back() > wide * sorted.front();
    if (axis.numeric && texts.size() > most_values) {
      put_into_bins(axis, rows, sorted);
    } else {
      for (std::size_t k = 0; k < texts.size(); ++k)
        axis.bins.push_back({texts[k], axis.numeric ? numbers[k] : static_cast<double>(k), {}});
      for (const SweepRow* row : rows) {
        const auto at = std::find(texts.begin(), texts.end(), row->values[i]) - texts.begin();
        axis.bins[static_cast<std::size_t>(at)].rows.push_back(row);
      }
      if (axis.numeric) {
        std::sort(axis.bins.begin(), axis.bins.end(), [](const Bin& a, const Bin& b) { return a.x < b.x; });
      }
    }
    axes.push_back(std::move(axis));
  }
  return axes;
}

/// Metrics that are told of one detector each, or a metric for itself.
struct Quantity {
  std::string label;
  struct Of {
    std::string name;  ///< the detector; empty for a metric for itself
    std::size_t metric = 0;
  };
  std::vector<Of> of;
};

/// "detectors.best.recall" is the recall of best.
Quantity::Of detector_of(const std::string& metric, std::size_t index, std::string& label) {
  constexpr std::string_view prefix = "detectors.";
  label = metric;
  if (!metric.starts_with(prefix)) return {"", index};
  const std::size_t end = metric.find('.', prefix.size());
  if (end == std::string::npos) return {"", index};
  label = metric.substr(end + 1);
  return {metric.substr(prefix.size(), end - prefix.size()), index};
}

std::vector<Quantity> quantities_of(const SweepTable& table) {
  std::vector<Quantity> quantities;
  for (std::size_t i = 0; i < table.metrics.size(); ++i) {
    std::string label;
    Quantity::Of of = detector_of(table.metrics[i], i, label);
    auto same = std::find_if(quantities.begin(), quantities.end(), [&](const Quantity& q) {
      return q.label == label && !of.name.empty() && !q.of.front().name.empty();
    });
    if (same == quantities.end()) same = quantities.insert(same, {label, {}});
    same->of.push_back(std::move(of));
  }
  return quantities;
}

/// Names of detectors in the order of the metrics and curves: what their colours go by.
std::vector<std::string> detectors_of(const SweepTable& table) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const Quantity& quantity : quantities_of(table))
    for (const Quantity::Of& of : quantity.of) add(of.name);
  for (const SweepRow& row : table.rows)
    for (const auto& [name, curve] : row.curves) add(name);
  return names;
}

MeanSd mean_of(const Rows& rows, std::size_t metric) {
  std::vector<std::optional<double>> values;
  for (const SweepRow* row : rows) values.push_back(row->metrics[metric]);
  return mean_sd_of(values);
}

Rows intersection(const Rows& a, const Rows& b) {
  const std::set<const SweepRow*> in_b(b.begin(), b.end());
  Rows both;
  std::copy_if(a.begin(), a.end(), std::back_inserter(both),
               [&](const SweepRow* row) { return in_b.contains(row); });
  return both;
}

/// Runs that are shown together.
struct Facet {
  std::string label;
  Rows rows;
};

/// The combinations of all axes but one, where they are few; otherwise all runs together.
std::vector<Facet> facets_of(const std::vector<Axis>& axes, const Axis& shown, const Rows& rows) {
  std::vector<Facet> facets = {{"", rows}};
  for (const Axis& axis : axes) {
    if (axis.key == shown.key) continue;
    std::vector<Facet> split;
    for (const Facet& facet : facets) {
      for (const Bin& bin : axis.bins) {
        Facet part{facet.label + (facet.label.empty() ? "" : ", ") + axis.key + " " + bin.label,
                   intersection(facet.rows, bin.rows)};
        if (!part.rows.empty()) split.push_back(std::move(part));
      }
    }
    facets = std::move(split);
    if (facets.size() > most_panels || axis.binned) return {{"", rows}};
  }
  return facets;
}

/// Whether an axis of words is there as the panels of the figures over an axis of numbers.
bool is_told_by_panels(const Axis& axis, const std::vector<Axis>& axes, const Rows& rows) {
  return !axis.numeric && std::any_of(axes.begin(), axes.end(), [&](const Axis& other) {
    return other.numeric && facets_of(axes, other, rows).size() > 1;
  });
}

/// What an axis needs below the panel: its scale, or the names of its values.
std::string x_axis_commands(const Axis& axis) {
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
  std::string tics;
  for (const Bin& bin : axis.bins)
    tics += fmt::format("{}{} {}", tics.empty() ? "" : ", ", gnuplot_quoted(bin.label), bin.x);
  return fmt::format("unset logscale x\nset xrange [-0.4:{}]\nset xtics ({})\n", axis.bins.back().x + 0.4,
                     tics);
}

/// A metric of one detector over an axis: means, bars and, where values are many, the runs. `shift` keeps the bars of
/// several detectors apart where values are words.
std::vector<Series> metric_series(const Quantity::Of& of, const Axis& axis, const Facet& facet,
                                  const std::string& colour, double shift, bool in_key) {
  const std::string name = of.name.empty() ? std::string("mean") : of.name;
  const std::string where = facet.label.empty() ? "" : ", " + facet.label;
  Series means{name + where, line_style(colour, 2.0), {}, false};
  Series marks{name + where + ", mean", dot_style(colour, 0.7), {}, false};
  Series bars{name + where + ", mean -+ sd", line_style(colour, 1.2), {}, false};
  Series runs{name + where + ", runs", dot_style(colour, 0.28), {}, false};
  for (const Bin& bin : axis.bins) {
    const Rows rows = intersection(bin.rows, facet.rows);
    const MeanSd mean = mean_of(rows, of.metric);
    if (!mean.mean) continue;
    const double x = bin.x + (axis.numeric ? 0.0 : shift);
    means.points.push_back({x, *mean.mean, 0.0});
    if (mean.sd) {
      bars.points.push_back({x, *mean.mean - *mean.sd, 0.0});
      bars.points.push_back({x, *mean.mean + *mean.sd, 0.0});
      bars.points.push_back({nan, nan, nan});
    }
    if (!axis.binned) continue;
    for (const SweepRow* row : rows) {
      if (row->metrics[of.metric])
        runs.points.push_back({*number_of(row->values[axis.index]), *row->metrics[of.metric], 0.0});
    }
  }
  marks.points = means.points;
  if (!axis.numeric) means.points.clear();  // words are not joined by a line
  Series& named = axis.numeric ? means : marks;
  named.title = name;
  named.in_key = in_key;
  std::vector<Series> series;
  for (Series* s : {&runs, &bars, &means, &marks})
    if (!s->points.empty()) series.push_back(std::move(*s));
  return series;
}

std::string layout_of(std::size_t panels, int& height) {
  const std::size_t columns = panels == 1 ? 1 : panels == 2 || panels == 4 ? 2 : 3;
  const std::size_t rows = (panels + columns - 1) / columns;
  height = rows == 1 ? 400 : static_cast<int>(330 * rows);
  return fmt::format("set multiplot layout {},{}\n", rows, columns);
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

std::string curves_html(const Quantity& quantity, const Axis& axis, const std::vector<Axis>& axes,
                        const Rows& rows, const std::vector<std::string>& detectors, const fs::path& folder) {
  const std::vector<Facet> facets = facets_of(axes, axis, rows);
  int height = 0;
  const std::string layout = layout_of(facets.size(), height);
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
  GnuplotFigure figure(name, figure_parts::width, height);
  for (std::size_t f = 0; f < facets.size(); ++f) {
    std::vector<Series> series;
    for (std::size_t i = 0; i < quantity.of.size(); ++i) {
      const Quantity::Of& of = quantity.of[i];
      const double shift =
          0.08 * (static_cast<double>(i) - 0.5 * static_cast<double>(quantity.of.size() - 1));
      const auto colour = std::find(detectors.begin(), detectors.end(), of.name) - detectors.begin();
      for (Series& s : metric_series(of, axis, facets[f], detector_colour(static_cast<std::size_t>(colour)),
                                     shift, f == 0 && quantity.of.size() > 1))
        series.push_back(std::move(s));
    }
    figure.add_panel(
        {.x_label = axis.key,
         .y_label = quantity.label,
         .z_label = {},
         .commands = x_axis_commands(axis) +
                     fmt::format("set yrange [{:.6g}:{:.6g}]\nset title {} font ',11'\nset key bottom left\n",
                                 low, high + 0.06 * (high - low), gnuplot_quoted(facets[f].label)),
         .series = std::move(series)});
  }
  Figure drawn = figure.draw(layout);
  drawn.csv = numbers_of(quantity, axis, facets);
  const std::string reading = fmt::format(
      "The mean over {}; a bar reaches one standard deviation to both sides.{}",
      facets.size() == 1 && axes.size() > 1 ? "all else that is varied, seeds included" : "the seeds",
      axis.binned ? " Dots are runs; the line goes through the means of equal stretches." : "");
  return figure_html(quantity.label + " over " + axis.key, reading, drawn, folder);
}

/// From dark blue over green to yellow, 0 to 1 (after viridis, made for maps that all can read).
std::array<int, 3> map_colour(double share) {
  constexpr std::array<std::array<double, 3>, 5> anchors = {
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double place = std::clamp(share, 0.0, 1.0) * (anchors.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(place), anchors.size() - 2);
  const double t = place - static_cast<double>(i);
  std::array<int, 3> rgb{};
  for (std::size_t k = 0; k < 3; ++k)
    rgb[k] = static_cast<int>(std::lround(anchors[i][k] * (1.0 - t) + anchors[i + 1][k] * t));
  return rgb;
}

std::string hex(const std::array<int, 3>& rgb) {
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

/// A metric over two axes, the mean over all else.
std::string map_html(const std::string& title, std::size_t metric, const Axis& across, const Axis& down,
                     const fs::path& folder) {
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
  write_numbers(folder, name, csv);
  return figure_html(
      title + " over " + across.key + " and " + down.key,
      fmt::format("The mean over seeds and all else that is varied, from {} (dark) to {} (bright). "
                  "<a href=\"figures/{}.csv\">Numbers</a>",
                  short_number(low), short_number(high), name),
      html);
}

std::string maps_html(const SweepTable& table, const std::vector<Axis>& axes, const fs::path& folder) {
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

std::string precision_recall_html(const Axis& axis, const std::vector<std::string>& detectors,
                                  const fs::path& folder) {
  if (axis.bins.size() > most_curves) return {};
  std::vector<GnuplotFigure::Panel> panels;
  for (const std::string& detector : detectors) {
    std::vector<Series> series;
    for (std::size_t i = 0; i < axis.bins.size(); ++i) {
      constexpr double brightest = 0.85;  // yellow does not show on white
      const double share = brightest * static_cast<double>(i) / static_cast<double>(axis.bins.size() - 1);
      std::vector<Point> points = mean_curve(axis.bins[i].rows, detector);
      if (points.empty()) continue;
      series.push_back(
          {axis.bins[i].label, line_style(hex(map_colour(share)), 2.0), std::move(points), panels.empty()});
    }
    if (series.empty() || panels.size() == most_panels) continue;
    panels.push_back({.x_label = "recall",
                      .y_label = "precision",
                      .z_label = {},
                      .commands = fmt::format(
                          "set xrange [0:1.01]\nset yrange [0:1.03]\nset title {} font ',11'\nset key bottom "
                          "left title {} font ',11'\n",
                          gnuplot_quoted(detector), gnuplot_quoted(panels.empty() ? axis.key : "")),
                      .series = std::move(series)});
  }
  if (panels.empty()) return {};
  int height = 0;
  const std::string layout = layout_of(panels.size(), height);
  GnuplotFigure figure(file_part("precision_recall_" + axis.key), figure_parts::width, height);
  for (GnuplotFigure::Panel& panel : panels) figure.add_panel(std::move(panel));
  return figure_html(
      "Precision and recall over " + axis.key,
      "A line for each value: the mean of the runs' precision at each recall, as far as all of them "
      "reach it. The further up and right, the better.",
      figure.draw(layout), folder);
}

std::string values_head(const SweepTable& table, const std::function<bool(std::size_t)>& wanted) {
  std::string html;
  for (std::size_t i = 0; i < table.axes.size(); ++i)
    if (wanted(i)) html += "<th>" + escaped(table.axes[i]) + "</th>";
  return html;
}

std::string value_cells(const SweepRow& row) {
  std::string html;
  for (const std::string& value : row.values) html += "<td>" + escaped(value) + "</td>";
  return html;
}

/// Every combination with its means, where they are few.
std::string means_html(const SweepTable& table, const Rows& rows) {
  const auto no_seed = [&](std::size_t axis) { return table.axes[axis] != seed_axis; };
  std::vector<std::pair<std::vector<std::string>, Rows>> combinations;
  std::map<std::vector<std::string>, std::size_t> places;
  for (const SweepRow* row : rows) {
    std::vector<std::string> values;
    for (std::size_t i = 0; i < row->values.size(); ++i)
      if (no_seed(i)) values.push_back(row->values[i]);
    const auto [place, is_new] = places.try_emplace(values, combinations.size());
    if (is_new) combinations.push_back({values, {}});
    combinations[place->second].second.push_back(row);
  }
  if (combinations.empty() || combinations.size() > most_table_rows) return {};
  std::string html = "<h2>Every combination</h2>\n<div class=\"wide\"><table><thead><tr>" +
                     values_head(table, no_seed) + "<th>runs</th>";
  for (const std::string& metric : table.metrics) {
    std::string label;
    const Quantity::Of of = detector_of(metric, 0, label);
    html += "<th>" + escaped(label) + (of.name.empty() ? "" : "<br>" + escaped(of.name)) + "</th>";
  }
  html += "</tr></thead><tbody>\n";
  for (const auto& [values, runs] : combinations) {
    html += "<tr>";
    for (const std::string& value : values) html += "<td>" + escaped(value) + "</td>";
    html += count_cell(std::ssize(runs));
    for (std::size_t m = 0; m < table.metrics.size(); ++m) html += cell(mean_of(runs, m), runs.size());
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string worst_html(const SweepTable& table, const fs::path& folder) {
  const std::vector<const SweepRow*> worst = worst_runs(table);
  if (worst.empty()) return {};
  std::string html = fmt::format(
      "<h2>The worst runs</h2>\n<p class=\"facts\">Those with the {} {}.</p>\n<div "
      "class=\"wide\"><table><thead><tr><th>run</th>{}<th>{}</th><th></th></tr></thead><tbody>\n",
      table.lowest_is_worst ? "lowest" : "highest", escaped(table.metrics.front()),
      values_head(table, [](std::size_t) { return true; }), escaped(table.metrics.front()));
  for (const SweepRow* row : worst) {
    const std::string report = "worst/" + row->id + "/report.html";
    html += fmt::format(
        "<tr>{}{}{}<td>{}</td></tr>\n", count_cell(row->run), value_cells(*row), cell(row->metrics.front()),
        fs::exists(folder / report) ? fmt::format("<a href=\"{}\">report</a>", report)
                                    : fmt::format("<code>saccade run runs/{}/scenario.yaml</code>", row->id));
  }
  return html + "</tbody></table></div>\n";
}

std::string failures_html(const SweepTable& table) {
  std::string rows;
  std::size_t count = 0;
  for (const SweepRow& row : table.rows) {
    if (row.status != "failed" || count++ >= most_failures) continue;
    rows += fmt::format("<tr>{}{}<td>{}</td><td><a href=\"runs/{}/log.txt\">log</a></td></tr>\n",
                        count_cell(row.run), value_cells(row), escaped(row.failure), row.id);
  }
  if (count == 0) return {};
  return fmt::format(
      "<h2>Failed runs</h2>\n<p class=\"facts\">{}{}</p>\n<div "
      "class=\"wide\"><table><thead><tr><th>run</th>{}"
      "<th>why</th><th></th></tr></thead><tbody>\n{}</tbody></table></div>\n",
      count, count > most_failures ? fmt::format("; the first {} of them", most_failures) : "",
      values_head(table, [](std::size_t) { return true; }), rows);
}

std::string axes_html(const SweepTable& table) {
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th>varied</th><th>values</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < table.axes.size(); ++i) {
    std::vector<std::string> texts;
    for (const SweepRow& row : table.rows) {
      if (texts.size() <= most_values && std::find(texts.begin(), texts.end(), row.values[i]) == texts.end())
        texts.push_back(row.values[i]);
    }
    std::string shown;
    if (texts.size() <= most_values) {
      for (const std::string& text : texts) shown += (shown.empty() ? "" : " · ") + escaped(text);
    } else {
      double low = nan;
      double high = nan;
      for (const SweepRow& row : table.rows) {
        low = std::fmin(low, number_of(row.values[i]).value_or(nan));
        high = std::fmax(high, number_of(row.values[i]).value_or(nan));
      }
      shown = std::isfinite(low) ? "many, from " + short_number(low) + " to " + short_number(high) : "many";
    }
    html += fmt::format("<tr><th>{}</th><td style=\"text-align:left;white-space:normal\">{}</td></tr>\n",
                        escaped(table.axes[i]), shown);
  }
  return html + "</tbody></table></div>\n";
}

void write_runs(const SweepTable& table, const fs::path& folder) {
  std::string csv = "run,id,status";
  for (const std::string& axis : table.axes) csv += "," + csv_field(axis);
  for (const std::string& metric : table.metrics) csv += "," + csv_field(metric);
  csv += "\n";
  for (const SweepRow& row : table.rows) {
    csv += fmt::format("{},{},{}", row.run, row.id, row.status);
    for (const std::string& value : row.values) csv += "," + csv_field(value);
    for (const auto& value : row.metrics) csv += "," + (value ? text_of(*value) : std::string());
    csv += "\n";
  }
  write_numbers(folder, "runs", csv);
}

}  // namespace

std::vector<const SweepRow*> worst_runs(const SweepTable& table) {
  std::vector<const SweepRow*> runs;
  std::set<std::string> seen;
  if (table.metrics.empty()) return runs;
  for (const SweepRow& row : table.rows)
    if (row.metrics.front() && seen.insert(row.id).second) runs.push_back(&row);
  std::stable_sort(runs.begin(), runs.end(), [&](const SweepRow* a, const SweepRow* b) {
    return table.lowest_is_worst ? *a->metrics.front() < *b->metrics.front()
                                 : *a->metrics.front() > *b->metrics.front();
  });
  runs.resize(std::min(runs.size(), table.worst));
  return runs;
}

void write_sweep_report(const SweepTable& table, const fs::path& folder) {
  const Rows rows = done_rows(table);
  const std::vector<Axis> axes = axes_of(table, rows);
  const std::vector<std::string> detectors = detectors_of(table);
  const auto count = [&](std::string_view status) {
    return std::count_if(table.rows.begin(), table.rows.end(),
                         [&](const SweepRow& row) { return row.status == status; });
  };
  std::string html;
  if (!table.description.empty()) html += "<p>" + escaped(table.description) + "</p>\n";
  html += fmt::format(
      "<p class=\"facts\">{} runs of {}: {} done, {} failed, {} to do · {} · the tables as numbers: "
      "<a href=\"figures/runs.csv\">every run</a>; all metrics are in sweep.sqlite</p>\n",
      table.rows.size(), escaped(table.scenario), count("done"), count("failed"), count("waiting"),
      escaped(table.version));
  html += axes_html(table);
  write_runs(table, folder);
  std::string curves;
  for (const Quantity& quantity : quantities_of(table)) {
    for (const Axis& axis : axes) {
      if (!is_told_by_panels(axis, axes, rows))
        curves += curves_html(quantity, axis, axes, rows, detectors, folder);
    }
  }
  if (!curves.empty()) html += "<h2>Over one axis</h2>\n" + curves;
  if (const std::string maps = maps_html(table, axes, folder); !maps.empty())
    html += "<h2>Over two axes</h2>\n" + maps;
  std::string families;
  for (const Axis& axis : axes) families += precision_recall_html(axis, detectors, folder);
  if (!families.empty()) html += "<h2>Precision and recall</h2>\n" + families;
  html += worst_html(table, folder) + failures_html(table) + means_html(table, rows);
  write_page(folder, table.name, html);
}

}  // namespace saccade
