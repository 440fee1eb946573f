#include "apps/session/score_detections.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "apps/session/summary.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"

namespace saccade::inline v0_1 {
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

template <class Rows>
std::string span_of(const Rows& rows) {
  return fmt::format("from {:.3f} to {:.3f} s", static_cast<double>(rows.front().t_us) * 1e-6,
                     static_cast<double>(rows.back().t_us) * 1e-6);
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
  if (detections.back().t_us < truth.front().t_us || detections.front().t_us > truth.back().t_us) {
    throw InputError(settings.detections.string(),
                     "detections " + span_of(detections) + ", truth " + span_of(truth),
                     "detections in the clock of the truth");
  }
  std::vector<std::pair<std::string, DetectorScore>> scores;
  for (const std::string& name : names) {
    const auto given = settings.thresholds.find(name);
    const double threshold =
        given != settings.thresholds.end() ? given->second : std::numeric_limits<double>::quiet_NaN();
    scores.emplace_back(name, score_detector(truth, detections, name, threshold, chances_of(truth)));
  }
  if (settings.json) {
    fmt::print("{}", detectors_to_json(scores));
    return;
  }
  for (const auto& [name, score] : scores) print_summary(name, score);
}

}  // namespace saccade::inline v0_1
