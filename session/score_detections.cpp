#include "session/score_detections.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "session/summary.h"

namespace saccade {
namespace {

template <class Row>
std::vector<Row> rows_of(const std::filesystem::path& path) {
  std::vector<Row> rows = read_table<Row>(path);
  if (rows.empty()) throw InputError(path.string(), "a table without rows", "at least one row");
  return rows;
}

/// In the order in which they first appear.
std::vector<std::string> detectors_of(const std::vector<DetectionRow>& rows) {
  std::vector<std::string> names;
  for (const DetectionRow& row : rows) {
    if (std::ranges::find(names, row.detector) == names.end()) names.push_back(row.detector);
  }
  return names;
}

/// A detection between the instants of truth that has a row each millisecond is false: worth a line where there are some.
void warn_of_instants(const std::string& name, const SharedInstants& instants) {
  if (instants.shared == instants.detections) return;
  fmt::print(
      stderr,
      "saccade: warning: {}: {} of {} detections lie between the instants of the truth; each is false\n",
      name, instants.detections - instants.shared, instants.detections);
}

}  // namespace

void score_detections(const ScoreSettings& settings) {
  const auto truth = rows_of<TruthRow>(settings.truth);
  const auto detections = rows_of<DetectionRow>(settings.detections);
  const std::vector<std::string> names = detectors_of(detections);
  for (const auto& [name, threshold] : settings.thresholds) {
    if (std::ranges::find(names, name) == names.end())
      throw InputError("--threshold", name, fmt::format("one of {}", fmt::join(names, ", ")));
  }
  const Chances chances = chances_of(truth);
  for (const std::string& name : names) {
    const SharedInstants instants = check_instants(truth, detections, name, settings.detections.string());
    if (chances == Chances::simulated) warn_of_instants(name, instants);
  }
  std::vector<std::pair<std::string, DetectorScore>> scores;
  for (const std::string& name : names) {
    const auto given = settings.thresholds.find(name);
    const double threshold =
        given != settings.thresholds.end() ? given->second : std::numeric_limits<double>::quiet_NaN();
    scores.emplace_back(name, score_detector(truth, detections, name, threshold, chances));
  }
  if (settings.json) {
    fmt::print("{}", detectors_to_json(scores));
    return;
  }
  for (const auto& [name, score] : scores) print_summary(name, score);
}

}  // namespace saccade
