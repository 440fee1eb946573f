#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "apps/sweep/benchmark_result.h"
#include "evaluation/report/html.h"

namespace saccade {
namespace {

/// "best, 55 µs per call and 0.42 per event"
std::string class_text(const BenchmarkResult& result) {
  if (result.latency_machine.empty()) return "–";
  return fmt::format("{}, {} µs per call and {} per event", result.latency_class, result.latency.per_call_us,
                     result.latency.per_event_us);
}

std::string latency_text(const BenchmarkResult& result) {
  return result.latency_machine.empty() ? "none" : result.latency_machine;
}

std::string title_of(const BenchmarkResult& result) {
  return fmt::format("{}, version {}{}", result.list, result.list_version,
                     result.quick ? ", quick (no result of an entry)" : "");
}

std::string facts_of(const BenchmarkResult& result) {
  const auto count = [&](const auto& condition) { return std::ranges::count_if(result.rows, condition); };
  return fmt::format(
      "worlds with a ball: {}, without: {}, runs in the loop: {}; digest of their events {}; latencies of {}",
      count([](const auto& row) { return row.part == "ball"; }),
      count([](const auto& row) { return row.part == "none"; }),
      count([](const auto& row) { return row.loop; }), result.worlds_digest(), latency_text(result));
}

std::string interval_text(const BenchmarkFigure& figure) {
  return figure.low && figure.high ? fmt::format("{:.3f} to {:.3f}", *figure.low, *figure.high)
                                   : std::string("–");
}

std::string number_cell(const BenchmarkFigure& figure) {
  return figure.value ? short_number(*figure.value * figure.factor) : std::string("–");
}

using Figures = std::vector<BenchmarkFigure>;

/// Whether a figure is a column: not if it applies to none of the rows. Each row has all figures in one order.
std::vector<bool> columns_of(const std::vector<Figures>& rows) {
  std::vector<bool> columns(figures_of({}).size(), false);
  for (const Figures& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) columns[i] = columns[i] || row[i].value.has_value();
  }
  return columns;
}

/// The interval follows the average precision.
bool has_interval(const BenchmarkFigure& figure) { return figure.key == "average_precision"; }

std::vector<std::string> headings(const std::vector<bool>& columns) {
  std::vector<std::string> all;
  const Figures figures = figures_of({});
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (columns[i]) all.push_back(figures[i].heading);
    if (columns[i] && has_interval(figures[i])) all.emplace_back("95 % interval");
  }
  return all;
}

std::string figure_cells(const Figures& figures, const std::vector<bool>& columns) {
  std::string html;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (columns[i]) html += cell(figures[i].value, figures[i].factor);
    if (columns[i] && has_interval(figures[i])) html += "<td>" + interval_text(figures[i]) + "</td>";
  }
  return html;
}

std::string table_head(const std::string& first, const std::vector<bool>& columns,
                       const std::string& last = {}) {
  std::string html = "<div class=\"wide\"><table class=\"sort heads\"><thead><tr>" + first;
  for (const std::string& heading : headings(columns)) html += "<th>" + escaped(heading) + "</th>";
  return html + last + "</tr></thead><tbody>\n";
}

std::string kinds_html(const BenchmarkResult& result) {
  const std::vector<BenchmarkKind> kinds = kinds_of(result.rows);
  std::vector<Figures> figures;
  figures.reserve(kinds.size());
  for (const BenchmarkKind& kind : kinds) figures.push_back(figures_of(kind.rows));
  const std::vector<bool> columns = columns_of(figures);
  std::string html = table_head("<th>kind</th><th>value</th><th>worlds</th>", columns);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    html += fmt::format("<tr><th>{}</th><td>{}</td>{}{}</tr>\n", escaped(kinds[i].kind),
                        escaped(kinds[i].value), count_cell(static_cast<std::int64_t>(kinds[i].rows.size())),
                        figure_cells(figures[i], columns));
  }
  return html + "</tbody></table></div>\n";
}

std::string reliability_html(const BenchmarkResult& result) {
  const std::optional<Reliability> bins = reliability_of(result.rows);
  if (!bins) return "<p class=\"facts\">The score is no probability.</p>\n";
  std::string html =
      "<p class=\"facts\">All worlds, whatever the threshold: a score that is a probability equals the share "
      "of inliers.</p>\n<div class=\"wide\"><table><thead><tr><th>score "
      "from</th><th>observations</th><th>mean "
      "score</th><th>share of inliers</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < bins->size(); ++i) {
    const ReliabilityBin& bin = (*bins)[i];
    const auto mean = bin.observations > 0 ? std::optional(bin.mean_score) : std::nullopt;
    html += fmt::format("<tr><th>{:.1f}</th>{}{}{}</tr>\n",
                        static_cast<double>(i) / static_cast<double>(bins->size()),
                        count_cell(bin.observations), cell(mean), cell(bin.inlier_share()));
  }
  return html + "</tbody></table></div>\n";
}

std::string runs_html(const BenchmarkResult& result) {
  const std::vector<std::pair<std::string, std::string>> columns = {
      {"average_precision", "average precision"},
      {"recall", "recall"},
      {"precision", "precision"},
      {"alarm_ratio", "alarm share"},
      {"reaction_ms", "reaction, ms"},
      {"on_target_ratio", "on target, share"},
      {"acquire_s", "acquired after, s"},
      {"us_per_event", "µs per event"}};
  std::string html =
      "<div class=\"wide\"><table class=\"sort "
      "heads\"><thead><tr><th>run</th><th>sensor</th><th>image</th><th>events</th>";
  for (const auto& [key, heading] : columns) html += "<th>" + heading + "</th>";
  html += "<th>digest of the events</th><th>detector ended early</th></tr></thead><tbody>\n";
  const auto kind = [](const BenchmarkRow& row, const char* name) {
    const auto at = row.kinds.find(name);
    return at == row.kinds.end() ? std::string("–") : escaped(at->second);
  };
  for (const BenchmarkRow& row : result.rows) {
    html += fmt::format("<tr><th>{}</th><td>{}</td><td>{}</td>{}", escaped(row.run), kind(row, "sensor"),
                        kind(row, "image"), count_cell(row.events));
    for (const auto& [key, heading] : columns) html += cell(row.figure(key));
    html += fmt::format("<td>{}</td><td>{}</td></tr>\n", row.events_digest, escaped(row.failure));
  }
  return html + "</tbody></table></div>\n";
}

std::vector<Figures> figures_of_each(const BenchmarkGroup& group) {
  std::vector<Figures> figures;
  figures.reserve(group.size());
  for (const BenchmarkResult& result : group) figures.push_back(figures_of(result.rows));
  return figures;
}

}  // namespace

std::string benchmark_table_text(const std::vector<BenchmarkGroup>& groups) {
  std::string text;
  for (const BenchmarkGroup& group : groups) {
    const std::vector<Figures> figures = figures_of_each(group);
    const std::vector<bool> columns = columns_of(figures);
    text += fmt::format("{}## {}\n\n{}.\n\n| entry |", text.empty() ? "" : "\n", title_of(group.front()),
                        facts_of(group.front()));
    std::string rule = "|---|";
    for (const std::string& heading : headings(columns)) {
      text += " " + heading + " |";
      rule += "---:|";
    }
    text += " saccade |\n" + rule + "---|\n";
    for (std::size_t row = 0; row < group.size(); ++row) {
      text += "| " + group[row].entry + " |";
      for (std::size_t i = 0; i < columns.size(); ++i) {
        const BenchmarkFigure& figure = figures[row][i];
        if (columns[i]) text += " " + number_cell(figure) + " |";
        if (columns[i] && has_interval(figure)) text += " " + interval_text(figure) + " |";
      }
      text += " " + group[row].saccade + " |\n";
    }
  }
  return text;
}

void write_benchmark_table(const std::vector<BenchmarkGroup>& groups, const std::filesystem::path& file) {
  std::string html;
  for (const BenchmarkGroup& group : groups) {
    const std::vector<Figures> figures = figures_of_each(group);
    const std::vector<bool> columns = columns_of(figures);
    html += fmt::format("<h2>{}</h2>\n<p class=\"facts\">{}.</p>\n", escaped(title_of(group.front())),
                        escaped(facts_of(group.front()))) +
            table_head("<th>entry</th>", columns, "<th>latency</th><th>saccade</th><th>machine</th>");
    for (std::size_t row = 0; row < group.size(); ++row) {
      html +=
          fmt::format("<tr><th>{}</th>{}<td>{}</td><td>{}</td><td>{}</td></tr>\n", escaped(group[row].entry),
                      figure_cells(figures[row], columns), escaped(class_text(group[row])),
                      escaped(group[row].saccade), escaped(group[row].machine));
    }
    html += "</tbody></table></div>\n";
  }
  write_page_file(file, "Benchmark", html);
}

void write_benchmark_page(const BenchmarkResult& result, const std::filesystem::path& file) {
  std::string html = "<div class=\"cards\">";
  for (const BenchmarkFigure& figure : figures_of(result.rows)) {
    html += fmt::format("<div class=\"card\"><b>{}</b> {}{}</div>", number_cell(figure),
                        escaped(figure.heading), figure.low ? " (95 %: " + interval_text(figure) + ")" : "");
  }
  html += fmt::format(
      "</div>\n<p class=\"facts\">{} · {} ({}) · saccade {} · {}</p>\n<p class=\"facts\">Configuration: "
      "<code>{}</code></p>\n",
      escaped(title_of(result)), escaped(facts_of(result)), escaped(class_text(result)),
      escaped(result.saccade), escaped(result.machine), escaped(result.configuration));
  html += "<h2>By kind of world, those with a ball</h2>\n" + kinds_html(result);
  html += "<h2>Reliability</h2>\n" + reliability_html(result);
  html += "<h2>Every run</h2>\n" + runs_html(result);
  write_page_file(file, fmt::format("{}: {}", title_of(result), result.entry), html);
}

}  // namespace saccade
