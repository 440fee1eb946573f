#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace saccade {

/// How score_detections() runs.
struct ScoreSettings {
  std::filesystem::path detections;  ///< table as detections.csv; columns from `held` on may be absent
  std::filesystem::path truth;       ///< table as truth.csv; columns from `visible` on may be absent
  std::map<std::string, double> thresholds;  ///< by detector; without one figures at the threshold are none
  bool json = false;                         ///< print JSON, the detectors of metrics.json
};

/// Scores the detections of a table against truth and prints the figures of each detector. Truth with rows 1 ms apart is
/// scored as a simulation's, any other as the annotation of a recording (chances_of()). Throws InputError for broken
/// tables, tables without rows, a threshold of a detector that the table does not have, and tables whose times do not
/// fit (check_instants()).
void score_detections(const ScoreSettings& settings);

}  // namespace saccade
