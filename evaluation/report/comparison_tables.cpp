#include "evaluation/report/comparison_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "core/config.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/report/html.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// A figure of a detector or of a gaze. Its key is the name of a column in the CSV files.
template <class Score>
struct Quantity {
  std::string_view key;
  std::string_view heading;  ///< HTML
  std::optional<double> (*value)(const Score&);
};

constexpr std::size_t recall_20_percent = 1;
static_assert(reported_recalls[recall_20_percent] == 0.2);

constexpr Quantity<DetectorScore> detector_quantities[] = {
    {"average_precision", "average<br>precision", [](const DetectorScore& s) { return s.average_precision; }},
    {"precision_at_recall_0.2", "precision at<br>recall 0.2",
     [](const DetectorScore& s) { return s.precision_at_recall[recall_20_percent]; }},
    {"precision", "precision at<br>threshold", [](const DetectorScore& s) { return s.precision; }},
    {"recall", "recall at<br>threshold", [](const DetectorScore& s) { return s.recall; }},
    {"rate_mean_hz", "inliers per s,<br>mean", [](const DetectorScore& s) { return s.mean_rate_hz; }},
    {"rate_peak_hz", "inliers per s,<br>peak", [](const DetectorScore& s) { return s.peak_rate_hz; }},
    {"position_error_median_px", "position error,<br>median, px",
     [](const DetectorScore& s) { return s.position_error_px.median; }},
    {"lag_ms", "lag, ms", [](const DetectorScore& s) { return s.lag_ms; }},
    {"clutter_in_window_detected", "clutter where<br>it detected",
     [](const DetectorScore& s) { return s.clutter ? s.clutter->in_window_detected : std::nullopt; }},
    {"clutter_in_window_missed", "clutter where<br>it did not",
     [](const DetectorScore& s) { return s.clutter ? s.clutter->in_window_missed : std::nullopt; }},
    {"clutter_per_detection", "clutter events<br>per inlier",
     [](const DetectorScore& s) { return s.clutter ? s.clutter->per_detection : std::nullopt; }},
};
constexpr std::size_t clutter_quantities = 3;  // the last ones, of runs with labels

constexpr Quantity<GazeMetrics> gaze_quantities[] = {
    {"acquire_s", "acquired<br>after, s", [](const GazeMetrics& g) { return g.score.acquire_s; }},
    {"fixation_error_median_deg", "fixation error,<br>median, deg",
     [](const GazeMetrics& g) { return g.score.fixation_error_deg.median; }},
    {"fixation_error_p95_deg", "fixation error,<br>95 %, deg",
     [](const GazeMetrics& g) { return g.score.fixation_error_deg.p95; }},
    {"on_target_ratio", "on target,<br>share", [](const GazeMetrics& g) { return g.score.on_target_ratio; }},
    {"in_view_ratio", "in view,<br>share", [](const GazeMetrics& g) { return g.score.in_view_ratio; }},
    {"moves", "moves",
     [](const GazeMetrics& g) { return std::optional(static_cast<double>(g.score.moves)); }},
    {"wrong_moves", "wrong<br>moves",
     [](const GazeMetrics& g) { return std::optional(static_cast<double>(g.score.wrong_moves)); }},
    {"limit_violations", "limit<br>violations",
     [](const GazeMetrics& g) { return std::optional(static_cast<double>(g.score.limit_violations)); }},
    {"following_rate_hz", "detected while<br>following, per s",
     [](const GazeMetrics& g) { return g.following_rate_hz; }},
    {"saccades", "saccades",
     [](const GazeMetrics& g) { return std::optional(static_cast<double>(g.score.saccades)); }},
};

template <class Score>
MeanSd mean_of(const std::vector<Score>& scores, const Quantity<Score>& quantity) {
  std::vector<std::optional<double>> values;
  std::transform(scores.begin(), scores.end(), std::back_inserter(values), quantity.value);
  return mean_sd_of(values);
}

template <class Score>
std::string table_head(std::string_view id, std::string_view what,
                       std::span<const Quantity<Score>> quantities, std::string_view last = {}) {
  std::string html = fmt::format("<div class=\"wide\"><table id=\"{}\"><thead><tr><th>{}</th>", id, what);
  for (const auto& quantity : quantities) html += fmt::format("<th>{}</th>", quantity.heading);
  return html + std::string(last) + "</tr></thead><tbody>\n";
}

template <class Score>
std::string table_row(const std::string& name, const std::vector<Score>& scores,
                      std::span<const Quantity<Score>> quantities, const std::string& last = {}) {
  std::string html = "<tr><th>" + name + "</th>";
  for (const auto& quantity : quantities) html += cell(mean_of(scores, quantity), scores.size());
  return html + last + "</tr>\n";
}

/// Clutter only where a run has labels.
std::span<const Quantity<DetectorScore>> quantities_of(std::span<const ComparedGroup> groups) {
  const auto has_labels = [](const ComparedRun* run) { return run->metrics.clutter.has_value(); };
  const bool labels = std::any_of(groups.begin(), groups.end(), [&](const ComparedGroup& group) {
    return std::any_of(group.runs.begin(), group.runs.end(), has_labels);
  });
  const std::span<const Quantity<DetectorScore>> all(detector_quantities);
  return labels ? all : all.first(all.size() - clutter_quantities);
}

std::vector<std::pair<std::string, std::vector<GazeMetrics>>> gazes_of(const ComparedGroup& group) {
  std::vector<std::pair<std::string, std::vector<GazeMetrics>>> gazes;
  for (const ComparedRun* run : group.runs) {
    if (!run->metrics.gaze) continue;
    const std::string& driver = run->metrics.gaze->detector;
    auto at = std::find_if(gazes.begin(), gazes.end(), [&](const auto& g) { return g.first == driver; });
    if (at == gazes.end()) at = gazes.insert(at, {driver, {}});
    at->second.push_back(*run->metrics.gaze);
  }
  return gazes;
}

std::string csv_text(const std::optional<double>& value) { return value ? text_of(*value) : std::string(); }

template <class Score>
std::string csv_head(std::span<const Quantity<Score>> quantities, bool with_sd) {
  std::string line;
  for (const auto& quantity : quantities) {
    line += fmt::format(",{}", quantity.key);
    if (with_sd) line += fmt::format(",{}_sd", quantity.key);
  }
  return line;
}

template <class Score>
std::string csv_means(const std::vector<Score>& scores, std::span<const Quantity<Score>> quantities) {
  std::string line;
  for (const auto& quantity : quantities) {
    const MeanSd mean = mean_of(scores, quantity);
    line += "," + csv_text(mean.mean) + "," + csv_text(mean.sd);
  }
  return line;
}

/// The share of its events that the event camera dropped, over the runs of a group.
MeanSd dropped_of(const ComparedGroup& group) {
  std::vector<std::optional<double>> shares;
  for (const ComparedRun* run : group.runs) shares.push_back(dropped_share(run->metrics));
  return mean_sd_of(shares);
}

std::string group_fields(const ComparedGroup& group) {
  const Metrics& metrics = group.runs.front()->metrics;
  return csv_field(metrics.scenario) + "," + csv_field(settings_text(metrics));
}

}  // namespace

std::string compared_detectors_table(const ComparedGroup& group, std::size_t number) {
  const auto quantities = quantities_of({&group, 1});
  const MeanSd dropped = dropped_of(group);
  std::string html = table_head(fmt::format("group{}", number), "detector", quantities,
                                "<th>events that the<br>camera dropped, share</th>");
  for (const auto& [detector, scores] : group.detectors) {
    std::string name = colour_mark(detector.colour, detector.name);
    if (scores.size() < group.runs.size()) name += fmt::format(" <small>{} runs</small>", scores.size());
    html += table_row(name, scores, quantities, cell(dropped, group.runs.size()));
  }
  return html + "</tbody></table></div>\n";
}

std::string compared_gaze_table(const ComparedGroup& group, std::size_t number) {
  const auto gazes = gazes_of(group);
  if (gazes.empty()) return {};
  const std::span<const Quantity<GazeMetrics>> quantities(gaze_quantities);
  std::string html = table_head(fmt::format("gaze{}", number), "gaze driven by", quantities);
  for (const auto& [driver, scores] : gazes) html += table_row(escaped(driver), scores, quantities);
  return html + "</tbody></table></div>\n";
}

void write_comparison_tables(const std::vector<ComparedGroup>& groups, const fs::path& out) {
  const auto quantities = quantities_of(groups);
  const std::span<const Quantity<GazeMetrics>> gaze(gaze_quantities);
  std::string runs = "run,scenario,settings,seed,detector" + csv_head(quantities, false) +
                     ",events_dropped_share,interrupted\n";
  std::string means = "scenario,settings,detector,runs" + csv_head(quantities, true) +
                      ",events_dropped_share,events_dropped_share_sd\n";
  std::string gaze_means = "scenario,settings,detector,runs" + csv_head(gaze, true) + "\n";
  for (const ComparedGroup& group : groups) {
    const std::string fields = group_fields(group);
    const MeanSd dropped = dropped_of(group);
    for (const ComparedRun* run : group.runs) {
      for (const auto& [name, score] : run->metrics.detectors) {
        runs += fmt::format("{},{},{},{}", csv_field(run->folder.generic_string()), fields,
                            seed_text(run->metrics), csv_field(name));
        for (const auto& quantity : quantities) runs += "," + csv_text(quantity.value(score));
        runs += fmt::format(",{},{}\n", csv_text(dropped_share(run->metrics)), run->metrics.interrupted);
      }
    }
    for (const auto& [detector, scores] : group.detectors) {
      means += fmt::format("{},{},{}", fields, csv_field(detector.name), scores.size());
      means += csv_means(scores, quantities);
      means += "," + csv_text(dropped.mean) + "," + csv_text(dropped.sd) + "\n";
    }
    for (const auto& [driver, scores] : gazes_of(group)) {
      gaze_means += fmt::format("{},{},{}", fields, csv_field(driver), scores.size());
      gaze_means += csv_means(scores, gaze) + "\n";
    }
  }
  write_numbers(out, "runs", runs);
  write_numbers(out, "means", means);
  write_numbers(out, "gaze_means", gaze_means);
}

}  // namespace saccade
