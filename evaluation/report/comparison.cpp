#include "evaluation/report/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/report/ablation.h"
#include "evaluation/report/comparison_runs.h"
#include "evaluation/report/comparison_tables.h"
#include "evaluation/report/eye_movement_section.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/gaze_figures.h"
#include "evaluation/report/html.h"
#include "evaluation/report/mujoco_ranges.h"
#include "evaluation/report/report.h"
#include "evaluation/report/run_data.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_gaze_paths = 6;  // in the figure of the robot's frame

/// A path as a relative URL.
std::string link_to(const fs::path& path) {
  std::string link;
  for (const char c : path.generic_string()) {
    const bool plain = file_part(std::string(1, c)).front() == c || c == '/' || c == '.';
    link += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return link;
}

std::string links(const ComparedGroup& group, const fs::path& out, const FormatRegistry& formats) {
  std::string html =
      fmt::format("<p class=\"facts\">{} run{}", group.runs.size(), group.runs.size() == 1 ? "" : "s");
  for (const ComparedRun* run : group.runs) {
    if (!fs::exists(run->folder / "report.html")) write_report(run->folder, formats);
    const fs::path report = fs::weakly_canonical(run->folder) / "report.html";
    html += fmt::format(
        " · <a href=\"{}\">{}</a>{}", link_to(report.lexically_relative(fs::weakly_canonical(out))),
        run->metrics.seed ? "seed " + seed_text(run->metrics) : escaped(run->folder.filename().string()),
        run->metrics.interrupted ? " (interrupted)" : "");
  }
  html += "</p>\n";
  for (const ComparedRun* run : group.runs) {
    if (!run->metrics.interrupted) continue;
    html += fmt::format(
        "<p class=\"remark\">{} was interrupted after {:.3g} s: its figures, which the means contain, are of "
        "what "
        "was processed until then.</p>\n",
        escaped(run->folder.string()), run->metrics.duration_s);
  }
  for (const std::string& duplicate : group.duplicates) {
    html += "<p class=\"remark\">" + escaped(duplicate) + "</p>\n";
  }
  return html;
}

/// The gaze tables of a run.
struct GazeRun {
  std::string label;
  std::int64_t start_us = 0;
  std::vector<TruthRow> truth;
  std::vector<GazeRow> gaze;
  std::vector<EyeRow> eye;
};

/// Of the first run of a group that has a gaze.
std::optional<GazeRun> gaze_run_of(const ComparedGroup& group) {
  for (const ComparedRun* run : group.runs) {
    if (!run->metrics.gaze || !fs::exists(run->folder / "gaze.csv")) continue;
    std::string label =
        group.label + (run->metrics.seed ? ", seed " + seed_text(run->metrics) : std::string());
    return GazeRun{std::move(label), run->metrics.start_us, dense_truth(*run),
                   read_table<GazeRow>(run->folder / "gaze.csv"),
                   read_table_if_there<EyeRow>(run->folder / "eye.csv")};
  }
  return std::nullopt;
}

/// The gaze of one run of each group; of many groups the first of each scenario.
std::string gaze_paths_html(const std::vector<ComparedGroup>& groups, const FigureFolder& out) {
  std::set<std::string> scenarios;
  std::vector<GazeRun> shown;
  for (const ComparedGroup& group : groups) {
    if (groups.size() > max_gaze_paths && scenarios.contains(group.runs.front()->metrics.scenario)) continue;
    std::optional<GazeRun> run = gaze_run_of(group);
    if (!run || shown.size() == max_gaze_paths) continue;
    scenarios.insert(group.runs.front()->metrics.scenario);
    shown.push_back(std::move(*run));
  }
  if (shown.empty()) return {};
  std::vector<GazePath> drawn;
  for (const GazeRun& p : shown)
    drawn.push_back({p.label, {.truth = p.truth, .gaze = p.gaze, .eye = p.eye}, p.start_us});
  return figure_html("Gaze in the robot's frame",
                     "One run of each group, all on the same scale. Left: the plane in front of the robot as "
                     "the robot sees it; "
                     "right: the side view from its right. Where the gaze follows well its line lies on the "
                     "ball's path; the dots "
                     "are the gaze targets.",
                     gaze_paths_figure("gaze_paths", drawn), out);
}

/// The settings of a run that are the same at every frequency of a protocol.
std::string protocol_label(const Metrics& metrics) {
  std::string label = metrics.scenario;
  for (const auto& [key, value] : metrics.settings) {
    if (!key.ends_with("frequency_hz") && !key.ends_with("amplitude_deg")) label += ", " + key + "=" + value;
  }
  return label;
}

/// Eye movements of the first run of each group that has them.
std::string eye_movements_html(const std::vector<ComparedGroup>& groups, const FigureFolder& out) {
  std::vector<EyeMovementColumn> columns;
  std::vector<EyeMovementColumn> curves;
  for (const ComparedGroup& group : groups) {
    const Metrics& metrics = group.runs.front()->metrics;
    if (!metrics.gaze || !metrics.gaze->eye_movements) continue;
    columns.push_back({group.label, &*metrics.gaze->eye_movements});
    curves.push_back({protocol_label(metrics), &*metrics.gaze->eye_movements});
  }
  if (columns.empty()) return {};
  return "<h2>Eye movements</h2>\n<p class=\"facts\">Of the first run of each group.</p>\n" +
         eye_movement_table(columns) + bode_figures(curves, out);
}

std::string group_html(const ComparedGroup& group, std::size_t number, const FigureFolder& out,
                       const FormatRegistry& formats) {
  std::string html = "<h2>" + escaped(group.label) + "</h2>\n" + links(group, out.page, formats) +
                     compared_detectors_table(group, number) + compared_gaze_table(group, number);
  const bool scored = std::any_of(group.detectors.begin(), group.detectors.end(), [](const auto& d) {
    return std::any_of(d.scores.begin(), d.scores.end(), [](const auto& s) { return !s.pr_curve.empty(); });
  });
  if (scored) {
    html += figure_html(
        "Precision and recall",
        "Thin: each run; thick: the mean of the runs' precision at each recall, as far as all of them reach "
        "it. "
        "The square is the mean at the threshold in use. The further up and right, the better.",
        precision_recall_spread_figure(fmt::format("precision_recall_{}", number), group.detectors), out);
  }
  if (!group.speeds.empty()) {
    html += figure_html(
        "Detection rate over the ball's speed",
        "How often per second each detector is right at that speed of the ball in the image, all runs "
        "together. 1000 per second is a ball found at every millisecond; speeds seen for less than 50 ms are "
        "left out.",
        rate_over_speed_figure(fmt::format("rate_over_speed_{}", number), group.speeds), out);
  }
  return html;
}

}  // namespace

std::vector<std::string> write_comparison(std::span<const fs::path> folders, const fs::path& page,
                                          const FormatRegistry& formats, const fs::path& figures) {
  const FigureFolder out{page, figures};
  const std::vector<ComparedRun> runs = load_runs(folders);
  const std::vector<ComparedGroup> groups = grouped(runs);
  std::string html =
      "<p class=\"facts\">Runs that differ in their seeds alone form a group: mean ± standard deviation over "
      "them. An observation is right within 6 px of the true centre and 2 px of the true radius. – "
      "means "
      "that the figure does not apply. The tables as numbers: <a href=\"figures/means.csv\">means</a>, <a "
      "href=\"figures/runs.csv\">every run</a>, <a href=\"figures/gaze_means.csv\">gaze</a>.</p>\n";
  std::vector<std::string> versions;
  for (const ComparedRun& run : runs) {
    if (const auto version = run.keys.find("version"); version != run.keys.end())
      versions.push_back(version->second);
  }
  std::vector<std::string> remarks;
  if (const std::string warning = mujoco_warning(versions); !warning.empty()) {
    remarks.push_back("warning: " + warning);
    html += "<p class=\"remark\">Warning: " + escaped(warning) + "</p>\n";
  }
  write_comparison_tables(groups, page);
  std::vector<AblationRun> ablated;
  for (const ComparedGroup& group : groups) {
    for (const ComparedRun* run : group.runs) ablated.push_back({&run->metrics, run->keys});
  }
  const std::string ablation = ablation_html(ablated, page);
  if (!ablation.empty()) html += "<p><a href=\"#ablation\">Ablation of the gaze</a></p>\n";
  std::vector<RunGroup> drawn;
  for (const ComparedGroup& group : groups) drawn.push_back({group.label, group.detectors});
  html +=
      figure_html("Average precision",
                  "A dot for every run; the bar reaches one standard deviation to both sides of the mean.",
                  average_precision_figure("average_precision", drawn), out);
  html += gaze_paths_html(groups, out) + eye_movements_html(groups, out) + ablation;
  for (std::size_t i = 0; i < groups.size(); ++i) html += group_html(groups[i], i + 1, out, formats);
  write_page(page, fmt::format("{} runs compared", runs.size()), html);
  for (const ComparedGroup& group : groups)
    remarks.insert(remarks.end(), group.duplicates.begin(), group.duplicates.end());
  return remarks;
}

}  // namespace saccade
