#include "evaluation/report/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/config.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/report/html.h"
#include "evaluation/report/sweep_axes.h"
#include "evaluation/report/sweep_figures.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {

using namespace sweep;

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_table_rows = 100;
constexpr std::size_t most_failures = 50;
constexpr std::size_t most_run_rows = 2'000;

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
  std::string html = "<h2>Every combination</h2>\n<div class=\"wide\"><table class=\"sort\"><thead><tr>" +
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

/// Every run that is done, to sort and to filter.
std::string runs_html(const SweepTable& table, const Rows& rows) {
  if (rows.empty() || table.metrics.empty()) return {};
  std::string html =
      "<h2>Every run</h2>\n<p class=\"facts\">A click on a heading sorts. The filter takes words and "
      "conditions such as "
      "<code>" +
      escaped(table.axes.empty() ? table.metrics.front() : table.axes.front()) + "&lt;1</code>.";
  if (rows.size() > most_run_rows)
    html += fmt::format(" The first {} of {} runs; figures/runs.csv has all.", most_run_rows, rows.size());
  html += "</p>\n<div class=\"wide\"><table class=\"sort\" id=\"runs\"><thead><tr><th>run</th>" +
          values_head(table, [](std::size_t) { return true; });
  for (const std::string& metric : table.metrics) html += "<th>" + escaped(metric) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < std::min(rows.size(), most_run_rows); ++i) {
    const SweepRow& row = *rows[i];
    html += "<tr>" + count_cell(row.run) + value_cells(row);
    for (const auto& value : row.metrics) html += cell(value);
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
      double low = std::nan("");
      double high = std::nan("");
      for (const SweepRow& row : table.rows) {
        low = std::fmin(low, number_of(row.values[i]).value_or(std::nan("")));
        high = std::fmax(high, number_of(row.values[i]).value_or(std::nan("")));
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

void write_sweep_report(const SweepTable& table, const fs::path& folder, const fs::path& figures) {
  const FigureFolder out{folder, figures};
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
      if (!is_shown_by_panels(axis, axes, rows)) curves += sweep_curves_html(quantity, axis, axes, rows, out);
    }
  }
  if (!curves.empty()) html += "<h2>Over one axis</h2>\n" + curves;
  if (const std::string maps = sweep_maps_html(table, axes, out); !maps.empty())
    html += "<h2>Over two axes</h2>\n" + maps;
  std::string families;
  for (const Axis& axis : axes) families += sweep_precision_recall_html(axis, detectors, out);
  if (!families.empty()) html += "<h2>Precision and recall</h2>\n" + families;
  html += worst_html(table, folder) + failures_html(table) + means_html(table, rows) + runs_html(table, rows);
  write_page(folder, table.name, html);
}

}  // namespace saccade
