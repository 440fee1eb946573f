#include "evaluation/report/ablation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/config.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/report/html.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {
namespace {

/// Controller, detector, window, gate.
using Combination = std::array<std::string, 4>;
constexpr std::array<std::string_view, 4> combination_names = {"controller", "detector", "window", "gate"};

enum class Better { smaller, larger, neither };

struct Column {
  std::string_view key;      ///< in the CSV
  std::string_view heading;  ///< HTML
  Better better;
  std::optional<double> (*value)(const Metrics&);
};

constexpr Column ablation_columns[] = {
    {"fixation_error_median_deg", "fixation error,<br>median, deg", Better::smaller,
     [](const Metrics& m) { return m.gaze->score.fixation_error_deg.median; }},
    {"on_target_ratio", "on target,<br>share", Better::larger,
     [](const Metrics& m) { return m.gaze->score.on_target_ratio; }},
    {"following_rate_hz", "detected while<br>following, per s", Better::larger,
     [](const Metrics& m) { return m.gaze->following_rate_hz; }},
    {"saccades_per_s", "saccades<br>per s", Better::neither,
     [](const Metrics& m) {
       return m.duration_s > 0.0 ? std::optional(static_cast<double>(m.gaze->score.saccades) / m.duration_s)
                                 : std::nullopt;
     }},
    {"wrong_moves", "wrong<br>moves", Better::smaller,
     [](const Metrics& m) { return std::optional(static_cast<double>(m.gaze->score.wrong_moves)); }},
};
constexpr std::size_t column_count = std::size(ablation_columns);

struct Row {
  Combination combination;
  ResolvedKeys keys;  ///< of all of its runs
  std::vector<const Metrics*> runs;

  [[nodiscard]] MeanSd mean(const Column& column) const {
    std::vector<std::optional<double>> values;
    for (const Metrics* run : runs) values.push_back(column.value(*run));
    return mean_sd_of(values);
  }
};

struct Table {
  std::string scenario;
  std::string settings;  ///< those that make no combination
  std::string world;     ///< world_text() of its runs
  std::vector<Row> rows;
};

bool makes_combination(std::string_view key) {
  return key == "gaze.controller" || key == "gaze.gate" || key == "gaze.detector" ||
         (key.starts_with("detectors.") && key.find(".window") != std::string_view::npos);
}

std::string other_settings(const Metrics& metrics) {
  std::string text;
  for (const auto& [key, value] : metrics.settings) {
    if (!makes_combination(key)) text += fmt::format("{}{}={}", text.empty() ? "" : ", ", key, value);
  }
  return text;
}

/// Rows in the order in which the names of their combinations first came.
void sort_rows(std::vector<Row>& rows) {
  const std::vector<Row> as_they_came = rows;
  const auto rank = [&](const Row& row) {
    std::array<std::size_t, 4> ranks{};
    for (std::size_t i = 0; i < ranks.size(); ++i) {
      while (as_they_came[ranks[i]].combination[i] != row.combination[i]) ++ranks[i];
    }
    return ranks;
  };
  std::stable_sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) { return rank(a) < rank(b); });
}

std::vector<Table> tables_of(std::span<const AblationRun> runs) {
  std::vector<Table> tables;
  for (const AblationRun& ablated : runs) {
    const Metrics* const run = ablated.metrics;
    const ResolvedKeys& keys = ablated.keys;
    if (!run->gaze || run->gaze->controller.empty()) continue;
    const std::string settings = other_settings(*run);
    const std::string world = world_text(keys);
    auto table = std::find_if(tables.begin(), tables.end(), [&](const Table& t) {
      return t.scenario == run->scenario && t.settings == settings && t.world == world;
    });
    if (table == tables.end()) table = tables.insert(table, {run->scenario, settings, world, {}});
    const Combination combination = {run->gaze->controller, run->gaze->detector, run->gaze->window,
                                     run->gaze->gate};
    auto row = std::find_if(table->rows.begin(), table->rows.end(),
                            [&](const Row& r) { return r.combination == combination && r.keys == keys; });
    if (row == table->rows.end()) row = table->rows.insert(row, {combination, keys, {}});
    row->runs.push_back(run);
  }
  std::erase_if(tables, [](const Table& table) { return table.rows.size() < 2; });
  for (Table& table : tables) sort_rows(table.rows);
  return tables;
}

/// The best mean of a column; none where all are the same or there is nothing to be best at.
std::optional<double> best_of(const Table& table, const Column& column) {
  std::vector<double> means;
  for (const Row& row : table.rows) {
    if (const auto mean = row.mean(column).mean) means.push_back(*mean);
  }
  if (column.better == Better::neither || means.empty()) return std::nullopt;
  const auto [smallest, largest] = std::minmax_element(means.begin(), means.end());
  if (*smallest == *largest) return std::nullopt;
  return column.better == Better::smaller ? *smallest : *largest;
}

std::string table_html(const Table& table) {
  std::string html = "<h3>" + escaped(table.scenario);
  if (!table.settings.empty()) html += " · " + escaped(table.settings);
  html += "</h3>\n<div class=\"wide\"><table class=\"ablation\"><thead><tr>";
  for (const std::string_view name : combination_names) html += fmt::format("<th>{}</th>", name);
  html += "<th>runs</th>";
  for (const Column& column : ablation_columns) html += fmt::format("<th>{}</th>", column.heading);
  html += "</tr></thead><tbody>\n";
  std::array<std::optional<double>, column_count> best;
  for (std::size_t c = 0; c < column_count; ++c) best[c] = best_of(table, ablation_columns[c]);
  for (const Row& row : table.rows) {
    html += "<tr>";
    for (const std::string& name : row.combination)
      html += "<th>" + (name.empty() ? std::string("–") : escaped(name)) + "</th>";
    html += count_cell(std::ssize(row.runs));
    for (std::size_t c = 0; c < column_count; ++c) {
      const MeanSd mean = row.mean(ablation_columns[c]);
      std::string text = cell(mean, row.runs.size());
      if (best[c] && mean.mean == best[c]) text.insert(text.find(' '), " class=\"best\"");
      html += text;
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string csv_of(const std::vector<Table>& tables) {
  std::string csv = "scenario,settings";
  for (const std::string_view name : combination_names) csv += fmt::format(",{}", name);
  csv += ",runs";
  for (const Column& column : ablation_columns) csv += fmt::format(",{0},{0}_sd", column.key);
  csv += "\n";
  const auto number = [](const std::optional<double>& value) {
    return value ? text_of(*value) : std::string();
  };
  for (const Table& table : tables) {
    for (const Row& row : table.rows) {
      csv += csv_field(table.scenario) + "," + csv_field(table.settings);
      for (const std::string& name : row.combination) csv += "," + csv_field(name);
      csv += fmt::format(",{}", row.runs.size());
      for (const Column& column : ablation_columns) {
        const MeanSd mean = row.mean(column);
        csv += "," + number(mean.mean) + "," + number(mean.sd);
      }
      csv += "\n";
    }
  }
  return csv;
}

}  // namespace

std::string ablation_html(std::span<const AblationRun> runs, const std::filesystem::path& out) {
  const std::vector<Table> tables = tables_of(runs);
  if (tables.empty()) return {};
  write_numbers(out, "ablation", csv_of(tables));
  std::string html =
      "<h2 id=\"ablation\">Ablation of the gaze</h2>\n<p class=\"facts\">The gaze with each combination of "
      "controller, "
      "detector, window of events and gate: mean ± standard deviation over the runs; the best of a column is "
      "marked. While following: from acquisition to the end. <a "
      "href=\"figures/ablation.csv\">Numbers</a></p>\n";
  for (const Table& table : tables) html += table_html(table);
  return html;
}

}  // namespace saccade
