#include "apps/sweep/comparison_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/report/html.h"

namespace saccade {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + escaped(word);
  return text.empty() ? "none" : text;
}

std::string side_html(const char* name, const RunSet& set) {
  return fmt::format("<tr><th>{}</th><td>{}</td><td>{}</td>{}{}</tr>\n", name, escaped(set.path.string()),
                     joined(set.versions), count_cell(static_cast<std::int64_t>(set.runs)),
                     count_cell(static_cast<std::int64_t>(set.failed)));
}

std::string figure_row(const ComparedFigure& figure, std::size_t runs_a, std::size_t runs_b) {
  std::optional<double> difference;
  std::optional<double> share;
  if (figure.a.mean && figure.b.mean) {
    difference = *figure.b.mean - *figure.a.mean;
    if (*figure.a.mean != 0.0) share = *difference / std::abs(*figure.a.mean);
  }
  return fmt::format("<tr{}><th>{}</th>{}{}{}{}{}{}<td>{}</td></tr>\n",
                     figure.changed ? " class=\"changed\"" : "", escaped(figure.name), cell(figure.a, runs_a),
                     cell(figure.b, runs_b), cell(difference), cell(share, 100.0), cell(figure.tolerance),
                     cell(figure.p_value), figure.changed ? "changed" : "equal");
}

std::string set_html(const ComparedSet& set) {
  if (set.seeds_a.empty() || set.seeds_b.empty())
    return fmt::format("<h2>{}</h2>\n<p class=\"remark\">only in {}</p>\n", escaped(set.label),
                       set.seeds_a.empty() ? "B" : "A");
  const auto changed = std::ranges::count_if(set.figures, [](const auto& figure) { return figure.changed; });
  std::string html =
      fmt::format("<h2>{}</h2>\n<p class=\"facts\">{} of {} figures changed · seeds {} in A, {} in B{}</p>\n",
                  escaped(set.label), changed, set.figures.size(), joined(set.seeds_a), joined(set.seeds_b),
                  set.paired ? ", compared seed by seed" : "");
  if (!set.configuration.empty())
    html += "<p class=\"remark\">Configuration of B: " + escaped(set.configuration) + "</p>\n";
  html +=
      "<div class=\"wide\"><table "
      "class=\"sort\"><thead><tr><th>figure</th><th>A</th><th>B</th><th>difference</th>"
      "<th>%</th><th>tolerance</th><th>p</th><th>result</th></tr></thead><tbody>\n";
  // What has changed comes first.
  for (const bool wanted : {true, false}) {
    for (const ComparedFigure& figure : set.figures) {
      if (figure.changed == wanted) html += figure_row(figure, set.seeds_a.size(), set.seeds_b.size());
    }
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace

void write_comparison_page(const RunComparison& comparison, const std::filesystem::path& file) {
  std::string html = fmt::format("<div class=\"cards\"><div class=\"card\"><b>{}</b> {}</div></div>\n",
                                 comparison.different() ? "different" : "equal",
                                 comparison.different() ? "beyond the tolerances" : "within the tolerances");
  html +=
      "<div class=\"wide\"><table><thead><tr><th></th><th>runs "
      "of</th><th>version</th><th>runs</th><th>without a "
      "result</th></tr></thead><tbody>\n" +
      side_html("A", comparison.a) + side_html("B", comparison.b) + "</tbody></table></div>\n";
  if (const std::string warning = comparison_warning(comparison); !warning.empty())
    html += "<p class=\"remark\">" + escaped(warning) + "</p>\n";
  html += "<p class=\"facts\">" + escaped(comparison_rule) +
          " A click on a heading sorts; the filter takes words and conditions such as "
          "<code>p&lt;0.001</code>.</p>\n";
  for (const ComparedSet& set : comparison.sets) html += set_html(set);
  write_page_file(
      file, comparison.a.path.filename().string() + " and " + comparison.b.path.filename().string(), html);
}

}  // namespace saccade
