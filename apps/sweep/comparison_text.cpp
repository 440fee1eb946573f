#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "apps/sweep/run_comparison.h"
#include "evaluation/report/mujoco_ranges.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

std::string joined(const std::vector<std::string>& words, const char* none) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? none : text;
}

std::string count_of_runs(std::size_t count) {
  return fmt::format("{} {}", count, count == 1 ? "run" : "runs");
}

std::string side_line(const char* name, const RunSet& set) {
  std::string line = fmt::format("{}  {}: {}, {}", name, set.path.string(),
                                 joined(set.versions, "version unknown"), count_of_runs(set.runs));
  if (set.failed > 0) line += fmt::format(", {} without a result", set.failed);
  return line + "\n";
}

std::string value_text(const MeanSd& value) {
  if (!value.mean) return "null";
  std::string text = fmt::format("{:.5g}", *value.mean);
  if (value.sd) text += fmt::format(" ± {:.2g}", *value.sd);
  return text;
}

/// Characters, not bytes: ± has two bytes.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

using TableRow = std::array<std::string, 6>;

std::string aligned(const std::vector<TableRow>& rows) {
  std::array<std::size_t, 6> widths{};
  for (const TableRow& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]));
  }
  std::string text;
  for (const TableRow& row : rows) {
    std::string line = " ";
    for (std::size_t i = 0; i < row.size(); ++i)
      line += " " + row[i] + std::string(widths[i] - width_of(row[i]) + 1, ' ');
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string set_text(const ComparedSet& set) {
  if (set.seeds_a.empty() || set.seeds_b.empty())
    return fmt::format("{}: only in {}\n", set.label, set.seeds_a.empty() ? "B" : "A");
  const auto changed = std::ranges::count_if(set.figures, [](const auto& f) { return f.changed; });
  std::string text = fmt::format("{}: {} of {} figures changed", set.label, changed, set.figures.size());
  const char* test = set.paired ? ", paired" : "";
  text += set.seeds_a == set.seeds_b
              ? fmt::format(" (seeds {}{})\n", joined(set.seeds_a, "none"), test)
              : fmt::format(" (seeds {} in A, {} in B{})\n", joined(set.seeds_a, "none"),
                            joined(set.seeds_b, "none"), test);
  if (!set.configuration.empty()) text += "  configuration of B: " + set.configuration + "\n";
  if (changed == 0) return text;
  std::vector<TableRow> rows = {{"figure", "A", "B", "difference", "tolerance", "p"}};
  for (const ComparedFigure& figure : set.figures) {
    if (!figure.changed) continue;
    const bool both = figure.a.mean && figure.b.mean;
    rows.push_back({figure.name, value_text(figure.a), value_text(figure.b),
                    both ? fmt::format("{:+.4g}", *figure.b.mean - *figure.a.mean) : "",
                    fmt::format("{:.3g}", figure.tolerance),
                    figure.p_value ? fmt::format("{:.2g}", *figure.p_value) : ""});
  }
  return text + aligned(rows);
}

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json side_json(const RunSet& set) {
  return {{"path", set.path.string()},
          {"versions", set.versions},
          {"runs", set.runs},
          {"without_result", set.failed}};
}

Json value_json(const MeanSd& value) {
  return {{"mean", optional_json(value.mean)}, {"sd", optional_json(value.sd)}, {"count", value.count}};
}

}  // namespace

std::string comparison_warning(const RunComparison& comparison) {
  std::vector<std::string> versions = comparison.a.versions;
  versions.insert(versions.end(), comparison.b.versions.begin(), comparison.b.versions.end());
  return mujoco_warning(versions);
}

std::string comparison_text(const RunComparison& comparison) {
  std::string text = side_line("A", comparison.a) + side_line("B", comparison.b);
  if (const std::string warning = comparison_warning(comparison); !warning.empty())
    text += "warning: " + warning + "\n";
  for (const ComparedSet& set : comparison.sets) text += set_text(set);
  text += std::string(comparison_rule) + "\n";
  const std::size_t failed = comparison.a.failed + comparison.b.failed;
  if (failed > 0) return text + fmt::format("different: {} without a result\n", count_of_runs(failed));
  return text + (comparison.different() ? "different\n" : "equal within tolerance\n");
}

std::string comparison_json(const RunComparison& comparison) {
  Json sets = Json::array();
  for (const ComparedSet& set : comparison.sets) {
    Json figures = Json::array();
    for (const ComparedFigure& figure : set.figures) {
      figures.push_back({{"name", figure.name},
                         {"a", value_json(figure.a)},
                         {"b", value_json(figure.b)},
                         {"tolerance", figure.tolerance},
                         {"p", optional_json(figure.p_value)},
                         {"changed", figure.changed}});
    }
    sets.push_back({{"label", set.label},
                    {"seeds_a", set.seeds_a},
                    {"seeds_b", set.seeds_b},
                    {"paired", set.paired},
                    {"configuration", set.configuration},
                    {"figures", std::move(figures)}});
  }
  const Json json = {{"schema", 1},
                     {"a", side_json(comparison.a)},
                     {"b", side_json(comparison.b)},
                     {"warning", comparison_warning(comparison)},
                     {"rule", comparison_rule},
                     {"different", comparison.different()},
                     {"sets", std::move(sets)}};
  return json.dump(2) + "\n";
}

}  // namespace saccade
