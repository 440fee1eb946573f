#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace saccade {

/// A metrics.json or figures.json: its numbers by their paths, "detectors.best.recall"; none where the figure does not apply (null).
struct MetricsNumbers {
  std::string scenario;
  std::string settings;  ///< the overrides of the scenario, "key=value, ..."
  std::string seed;      ///< empty where there is none
  bool interrupted = false;
  /// Results: all but seed, settings, camera, calibration and limits, the bound of acquisition, and the two below.
  std::vector<std::pair<std::string, std::optional<double>>> metrics;
  /// What the wall clock measured: wall_s, real_time_factor, us_per_event.
  std::vector<std::pair<std::string, std::optional<double>>> times;
  /// By detector: [[threshold, precision, recall], ...] as JSON.
  std::vector<std::pair<std::string, std::string>> curves;
};

/// Throws RunError that names `place` for a text that is no metrics.json or figures.json.
[[nodiscard]] MetricsNumbers metrics_numbers(std::string_view text, const std::string& place);

}  // namespace saccade
