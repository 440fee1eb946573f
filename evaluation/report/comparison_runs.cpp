#include "evaluation/report/comparison_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/error.h"
#include "evaluation/report/run_data.h"
#include "evaluation/scoring/ball_speed.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

std::string label_of(const Metrics& metrics) {
  const std::string settings = settings_text(metrics);
  return settings.empty() ? metrics.scenario : metrics.scenario + " · " + settings;
}

/// The entry of that name, made where it is missing.
template <class Entry>
Entry& entry_of(std::vector<Entry>& entries, const DrawnDetector& detector) {
  for (Entry& entry : entries) {
    if (entry.detector.name == detector.name) return entry;
  }
  entries.push_back({detector, {}});
  return entries.back();
}

bool same_experiment(const ComparedRun& a, const ComparedRun& b) {
  if (a.metrics.scenario != b.metrics.scenario || a.keys != b.keys) return false;
  return !a.keys.empty() || a.metrics.settings == b.metrics.settings;
}

/// A run of the group with the same seed; null where there is none. Also null for a run
/// without seed and recorded configuration.
const ComparedRun* repeated_run(const ComparedGroup& group, const ComparedRun& run) {
  if (run.keys.empty() && !run.metrics.seed) return nullptr;
  const auto same = [&](const ComparedRun* other) { return other->metrics.seed == run.metrics.seed; };
  const auto at = std::find_if(group.runs.begin(), group.runs.end(), same);
  return at == group.runs.end() ? nullptr : *at;
}

void add_run(ComparedGroup& group, const ComparedRun& run, const std::vector<DrawnDetector>& palette) {
  group.runs.push_back(&run);
  const std::vector<TruthRow> truth = dense_truth(run);
  std::vector<DetectionRow> detections;
  if (!truth.empty()) detections = read_table<DetectionRow>(run.folder / "detections.csv");
  const std::vector<double> speed_px_s = image_speed_px_s(truth);
  for (const auto& [name, score] : run.metrics.detectors) {
    const auto drawn = std::find_if(palette.begin(), palette.end(),
                                    [&, &wanted = name](const DrawnDetector& d) { return d.name == wanted; });
    entry_of(group.detectors, *drawn).scores.push_back(score);
    if (truth.empty()) continue;
    entry_of(group.speeds, *drawn)
        .counts.add(found_at_chances(truth, detections, name, score.threshold), speed_px_s);
  }
}

/// The detectors of all runs with their colours.
std::vector<DrawnDetector> drawn_detectors(const std::vector<ComparedRun>& runs) {
  std::vector<std::string> names;
  for (const ComparedRun& run : runs) {
    for (const auto& [name, score] : run.metrics.detectors) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  std::vector<DrawnDetector> drawn;
  for (const std::string& name : names) drawn.push_back({name, detector_colour(name)});
  return drawn;
}

/// Groups of edited copies of a scenario have the same name and settings: their labels get what differs.
void make_labels_unique(std::vector<ComparedGroup>& groups) {
  std::vector<std::string> labels;
  for (const ComparedGroup& group : groups) labels.push_back(group.label);
  for (std::size_t i = 1; i < groups.size(); ++i) {
    const auto first = std::find(labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(i), labels[i]) -
                       labels.begin();
    if (static_cast<std::size_t>(first) == i) continue;
    const ComparedRun& model = *groups[static_cast<std::size_t>(first)].runs.front();
    groups[i].label += " · " + difference_text(model.keys, groups[i].runs.front()->keys);
  }
}

}  // namespace

std::vector<ComparedRun> load_runs(std::span<const fs::path> folders) {
  std::vector<ComparedRun> runs;
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
        runs.push_back({folder, read_metrics(folder / "metrics.json"), read_resolved_keys(folder)});
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

std::string seed_text(const Metrics& metrics) {
  return metrics.seed ? std::to_string(*metrics.seed) : std::string();
}

std::vector<TruthRow> dense_truth(const ComparedRun& run) {
  std::vector<TruthRow> truth = read_table_if_there<TruthRow>(run.folder / "truth.csv");
  if (!truth.empty() && !std::isfinite(truth.front().position_m.x())) truth.clear();
  return truth;
}

std::vector<ComparedGroup> grouped(const std::vector<ComparedRun>& runs) {
  std::vector<ComparedGroup> groups;
  const std::vector<DrawnDetector> palette = drawn_detectors(runs);
  std::vector<const ComparedRun*> order;  // an interrupted run does not stand for a whole one
  for (const bool interrupted : {false, true}) {
    for (const ComparedRun& run : runs) {
      if (run.metrics.interrupted == interrupted) order.push_back(&run);
    }
  }
  for (const ComparedRun* const at : order) {
    const ComparedRun& run = *at;
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&](const ComparedGroup& g) { return same_experiment(*g.runs.front(), run); });
    if (group == groups.end()) {
      group = groups.insert(group, ComparedGroup{label_of(run.metrics), {}, {}, {}, {}});
    }
    if (run.metrics.interrupted && !group->runs.empty() && !group->runs.front()->metrics.interrupted) {
      group->duplicates.push_back(fmt::format("{} was interrupted after {:.3g} s and is not counted",
                                              run.folder.string(), run.metrics.duration_s));
    } else if (const ComparedRun* other = repeated_run(*group, run)) {
      group->duplicates.push_back(fmt::format(
          "{} repeats {} ({}) and is not counted", run.folder.string(), other->folder.string(),
          run.metrics.seed ? "seed " + seed_text(run.metrics) : "the same recording and detectors"));
    } else {
      add_run(*group, run, palette);
    }
  }
  make_labels_unique(groups);
  return groups;
}

}  // namespace saccade
