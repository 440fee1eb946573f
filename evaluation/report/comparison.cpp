#include "evaluation/report/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "core/error.h"
#include "evaluation/report/ablation.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/gaze_figures.h"
#include "evaluation/report/html.h"
#include "evaluation/report/report.h"
#include "evaluation/scoring/ball_speed.h"
#include "evaluation/scoring/metrics.h"
#include "recording/run_files.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

struct Run {
  fs::path folder;
  Metrics metrics;
};

/// Runs that differ in nothing but their seeds, and what each detector did in them.
struct Group {
  std::string label;
  std::vector<const Run*> runs;
  std::vector<DetectorRuns> detectors;
  std::vector<DetectorSpeeds> speeds;
};

/// A number that is told of a detector or of a gaze. Its key heads a column of the tables in figures/.
template <class Score>
struct Quantity {
  std::string_view key;
  std::string_view heading;  ///< HTML
  std::optional<double> (*value)(const Score&);
};

constexpr std::size_t max_places = 6;  // in the figure of the robot's frame

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

std::vector<Run> load(std::span<const fs::path> folders) {
  std::vector<Run> runs;
  std::vector<Problem> problems;
  std::set<fs::path> seen;
  for (const fs::path& folder : folders) {
    std::error_code ignored;
    if (!fs::exists(folder / "metrics.json", ignored)) {
      problems.push_back({folder.string(), "no metrics.json", "the folder of a run"});
    } else if (!seen.insert(fs::weakly_canonical(folder)).second) {
      problems.push_back({folder.string(), "the same run twice", "each run once"});
    } else {
      try {
        runs.push_back({folder, read_metrics(folder / "metrics.json")});
      } catch (const InputError& error) {
        problems.insert(problems.end(), error.problems().begin(), error.problems().end());
      }
    }
  }
  if (!problems.empty()) throw InputError(std::move(problems));
  return runs;
}

std::string settings_text(const Metrics& metrics) {
  std::string text;
  for (const auto& [key, value] : metrics.settings) {
    text += fmt::format("{}{}={}", text.empty() ? "" : ", ", key, value);
  }
  return text;
}

std::string label_of(const Metrics& metrics) {
  const std::string settings = settings_text(metrics);
  return settings.empty() ? metrics.scenario : metrics.scenario + " · " + settings;
}

/// The entry of that name, made where it is missing. Colours go by the order of first appearance in all runs.
template <class Entry>
Entry& entry_of(std::vector<Entry>& entries, const DrawnDetector& detector) {
  for (Entry& entry : entries) {
    if (entry.detector.name == detector.name) return entry;
  }
  entries.push_back({detector, {}});
  return entries.back();
}

template <class Row>
std::vector<Row> read_if_there(const fs::path& path) {
  return fs::exists(path) ? read_table<Row>(path) : std::vector<Row>{};
}

/// Truth every millisecond, as a simulation has it; empty where the run has none.
std::vector<TruthRow> dense_truth(const Run& run) {
  std::vector<TruthRow> truth = read_if_there<TruthRow>(run.folder / "truth.csv");
  if (!truth.empty() && !std::isfinite(truth.front().position_m.x())) truth.clear();
  return truth;
}

void add_run(Group& group, const Run& run, std::vector<DrawnDetector>& palette) {
  group.runs.push_back(&run);
  const std::vector<TruthRow> truth = dense_truth(run);
  std::vector<DetectionRow> detections;
  if (!truth.empty()) detections = read_table<DetectionRow>(run.folder / "detections.csv");
  const std::vector<double> speed_px_s = image_speed_px_s(truth);
  for (const auto& [name, score] : run.metrics.detectors) {
    const auto same = [&, &wanted = name](const DrawnDetector& d) { return d.name == wanted; };
    auto drawn = std::find_if(palette.begin(), palette.end(), same);
    if (drawn == palette.end()) drawn = palette.insert(drawn, {name, detector_colour(palette.size())});
    entry_of(group.detectors, *drawn).scores.push_back(score);
    if (truth.empty()) continue;
    entry_of(group.speeds, *drawn)
        .counts.add(found_at_chances(truth, detections, name, score.threshold), speed_px_s);
  }
}

std::vector<Group> grouped(const std::vector<Run>& runs) {
  std::vector<Group> groups;
  std::vector<DrawnDetector> palette;
  for (const Run& run : runs) {
    const auto same = [&](const Group& g) {
      const Metrics& other = g.runs.front()->metrics;
      return other.scenario == run.metrics.scenario && other.settings == run.metrics.settings;
    };
    auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) group = groups.insert(group, Group{label_of(run.metrics), {}, {}, {}});
    add_run(*group, run, palette);
  }
  return groups;
}

std::string seed_text(const Metrics& metrics) {
  return metrics.seed ? std::to_string(*metrics.seed) : std::string();
}

/// A path as a link has it.
std::string link_to(const fs::path& path) {
  std::string link;
  for (const char c : path.generic_string()) {
    const bool plain = file_part(std::string(1, c)).front() == c || c == '/' || c == '.';
    link += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return link;
}

std::string links(const Group& group, const fs::path& out) {
  std::string html =
      fmt::format("<p class=\"facts\">{} run{}", group.runs.size(), group.runs.size() == 1 ? "" : "s");
  for (const Run* run : group.runs) {
    if (!fs::exists(run->folder / "report.html")) write_report(run->folder);
    const fs::path report = fs::weakly_canonical(run->folder) / "report.html";
    html += fmt::format(
        " · <a href=\"{}\">{}</a>", link_to(report.lexically_relative(fs::weakly_canonical(out))),
        run->metrics.seed ? "seed " + seed_text(run->metrics) : escaped(run->folder.filename().string()));
  }
  return html + "</p>\n";
}

template <class Score>
std::string table_head(std::string_view id, std::string_view what,
                       std::span<const Quantity<Score>> quantities) {
  std::string html = fmt::format("<div class=\"wide\"><table id=\"{}\"><thead><tr><th>{}</th>", id, what);
  for (const auto& quantity : quantities) html += fmt::format("<th>{}</th>", quantity.heading);
  return html + "</tr></thead><tbody>\n";
}

template <class Score>
std::string table_row(const std::string& name, const std::vector<Score>& scores,
                      std::span<const Quantity<Score>> quantities) {
  std::string html = "<tr><th>" + name + "</th>";
  for (const auto& quantity : quantities) html += cell(mean_of(scores, quantity), scores.size());
  return html + "</tr>\n";
}

/// What is told of detectors: of clutter only where a run has labels.
std::span<const Quantity<DetectorScore>> quantities_of(std::span<const Group> groups) {
  const auto has_labels = [](const Run* run) { return run->metrics.clutter.has_value(); };
  const bool labels = std::any_of(groups.begin(), groups.end(), [&](const Group& group) {
    return std::any_of(group.runs.begin(), group.runs.end(), has_labels);
  });
  const std::span<const Quantity<DetectorScore>> all(detector_quantities);
  return labels ? all : all.first(all.size() - clutter_quantities);
}

std::string detector_table(const Group& group, std::size_t number) {
  const auto quantities = quantities_of({&group, 1});
  std::string html = table_head(fmt::format("group{}", number), "detector", quantities);
  for (const auto& [detector, scores] : group.detectors) {
    std::string name = colour_mark(detector.colour, detector.name);
    if (scores.size() < group.runs.size()) name += fmt::format(" <small>{} runs</small>", scores.size());
    html += table_row(name, scores, quantities);
  }
  return html + "</tbody></table></div>\n";
}

std::vector<std::pair<std::string, std::vector<GazeMetrics>>> gazes_of(const Group& group) {
  std::vector<std::pair<std::string, std::vector<GazeMetrics>>> gazes;
  for (const Run* run : group.runs) {
    if (!run->metrics.gaze) continue;
    const std::string& driver = run->metrics.gaze->detector;
    auto at = std::find_if(gazes.begin(), gazes.end(), [&](const auto& g) { return g.first == driver; });
    if (at == gazes.end()) at = gazes.insert(at, {driver, {}});
    at->second.push_back(*run->metrics.gaze);
  }
  return gazes;
}

std::string gaze_table(const Group& group, std::size_t number) {
  const auto gazes = gazes_of(group);
  if (gazes.empty()) return {};
  const std::span<const Quantity<GazeMetrics>> quantities(gaze_quantities);
  std::string html = table_head(fmt::format("gaze{}", number), "gaze driven by", quantities);
  for (const auto& [driver, scores] : gazes) html += table_row(escaped(driver), scores, quantities);
  return html + "</tbody></table></div>\n";
}

std::string csv_text(const std::optional<double>& value) { return value ? text_of(*value) : std::string(); }

template <class Score>
std::string csv_head(std::span<const Quantity<Score>> quantities, bool spread) {
  std::string line;
  for (const auto& quantity : quantities) {
    line += fmt::format(",{}", quantity.key);
    if (spread) line += fmt::format(",{}_sd", quantity.key);
  }
  return line + "\n";
}

template <class Score>
std::string csv_spread(const std::vector<Score>& scores, std::span<const Quantity<Score>> quantities) {
  std::string line;
  for (const auto& quantity : quantities) {
    const MeanSd mean = mean_of(scores, quantity);
    line += "," + csv_text(mean.mean) + "," + csv_text(mean.sd);
  }
  return line + "\n";
}

std::string group_fields(const Group& group) {
  const Metrics& metrics = group.runs.front()->metrics;
  return csv_field(metrics.scenario) + "," + csv_field(settings_text(metrics));
}

/// The tables' numbers: every run for itself, and the means.
void write_tables(const std::vector<Group>& groups, const fs::path& out) {
  const auto quantities = quantities_of(groups);
  const std::span<const Quantity<GazeMetrics>> gaze(gaze_quantities);
  std::string runs = "run,scenario,settings,seed,detector" + csv_head(quantities, false);
  std::string means = "scenario,settings,detector,runs" + csv_head(quantities, true);
  std::string gaze_means = "scenario,settings,detector,runs" + csv_head(gaze, true);
  for (const Group& group : groups) {
    const std::string fields = group_fields(group);
    for (const Run* run : group.runs) {
      for (const auto& [name, score] : run->metrics.detectors) {
        runs += fmt::format("{},{},{},{}", csv_field(run->folder.generic_string()), fields,
                            seed_text(run->metrics), csv_field(name));
        for (const auto& quantity : quantities) runs += "," + csv_text(quantity.value(score));
        runs += "\n";
      }
    }
    for (const auto& [detector, scores] : group.detectors) {
      means += fmt::format("{},{},{}", fields, csv_field(detector.name), scores.size());
      means += csv_spread(scores, quantities);
    }
    for (const auto& [driver, scores] : gazes_of(group)) {
      gaze_means += fmt::format("{},{},{}", fields, csv_field(driver), scores.size());
      gaze_means += csv_spread(scores, gaze);
    }
  }
  write_numbers(out, "runs", runs);
  write_numbers(out, "means", means);
  write_numbers(out, "gaze_means", gaze_means);
}

/// The first run of a group that has a gaze, and its tables.
struct Place {
  std::string label;
  std::int64_t start_us = 0;
  std::vector<TruthRow> truth;
  std::vector<GazeRow> gaze;
  std::vector<EyeRow> eye;
};

std::optional<Place> place_of(const Group& group) {
  for (const Run* run : group.runs) {
    if (!run->metrics.gaze || !fs::exists(run->folder / "gaze.csv")) continue;
    std::string label =
        group.label + (run->metrics.seed ? ", seed " + seed_text(run->metrics) : std::string());
    return Place{std::move(label), run->metrics.start_us, dense_truth(*run),
                 read_table<GazeRow>(run->folder / "gaze.csv"),
                 read_if_there<EyeRow>(run->folder / "eye.csv")};
  }
  return std::nullopt;
}

/// Where the runs looked, one of each group; of many groups those alone that are the first of their scenario.
std::string places_html(const std::vector<Group>& groups, const fs::path& out) {
  std::set<std::string> scenarios;
  std::vector<Place> places;
  for (const Group& group : groups) {
    if (groups.size() > max_places && scenarios.contains(group.runs.front()->metrics.scenario)) continue;
    std::optional<Place> place = place_of(group);
    if (!place || places.size() == max_places) continue;
    scenarios.insert(group.runs.front()->metrics.scenario);
    places.push_back(std::move(*place));
  }
  if (places.empty()) return {};
  std::vector<GazePlace> drawn;
  for (const Place& p : places)
    drawn.push_back({p.label, {.truth = p.truth, .gaze = p.gaze, .eye = p.eye}, p.start_us});
  return figure_html(
      "Gaze in the robot's frame",
      "One run of each group, all on the same scale. Left: the plane before the robot as it sees it; "
      "right: seen from its right, with the depth. A gaze that follows well lays the blue line on the "
      "ball's grey path; the dots are the detections that it was told to look at.",
      gaze_places_figure("gaze_places", drawn), out);
}

std::string group_html(const Group& group, std::size_t number, const fs::path& out) {
  std::string html = "<h2>" + escaped(group.label) + "</h2>\n" + links(group, out) +
                     detector_table(group, number) + gaze_table(group, number);
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
        "How often per second each detector is right while the ball moves that fast in the image, all runs "
        "together. 1000 per second is a ball found at every millisecond; speeds seen for less than 50 ms are "
        "left out.",
        rate_over_speed_figure(fmt::format("rate_over_speed_{}", number), group.speeds), out);
  }
  return html;
}

}  // namespace

void write_comparison(std::span<const fs::path> folders, const fs::path& out) {
  const std::vector<Run> runs = load(folders);
  const std::vector<Group> groups = grouped(runs);
  std::string html =
      "<p class=\"facts\">Runs that differ in nothing but their seeds stand together: mean ± standard "
      "deviation "
      "over them. An observation is right within 6 px of the true centre and 2 px of the true radius. – "
      "means "
      "that the figure does not apply. The tables as numbers: <a href=\"figures/means.csv\">means</a>, <a "
      "href=\"figures/runs.csv\">every run</a>, <a href=\"figures/gaze_means.csv\">gaze</a>.</p>\n";
  write_tables(groups, out);
  std::vector<const Metrics*> metrics;
  for (const Run& run : runs) metrics.push_back(&run.metrics);
  const std::string ablation = ablation_html(metrics, out);
  if (!ablation.empty()) html += "<p><a href=\"#ablation\">Ablation of the gaze</a></p>\n";
  std::vector<RunGroup> drawn;
  for (const Group& group : groups) drawn.push_back({group.label, group.detectors});
  html +=
      figure_html("Average precision",
                  "A dot for every run; the bar reaches one standard deviation to both sides of the mean.",
                  average_precision_figure("average_precision", drawn), out);
  html += places_html(groups, out) + ablation;
  for (std::size_t i = 0; i < groups.size(); ++i) html += group_html(groups[i], i + 1, out);
  write_page(out, fmt::format("{} runs compared", runs.size()), html);
}

}  // namespace saccade
