#pragma once

#include <string>

#include "evaluation/scoring/metrics.h"

namespace saccade {

/// The tables and lines of a run's report, as HTML.

/// The detector's name with its colour.
[[nodiscard]] std::string detector_mark(const Metrics& metrics, std::size_t index);
[[nodiscard]] std::string detector_table(const Metrics& metrics);
/// Detector, window, gate and controller of the gaze, in one line.
[[nodiscard]] std::string gaze_line(const GazeMetrics& gaze);
[[nodiscard]] std::string gaze_table(const GazeMetrics& gaze, double duration_s);
/// Shares of the events by object and cause; empty where the events have no labels.
[[nodiscard]] std::string clutter_tables(const Metrics& metrics);
/// Events that detectors could not use; empty where there are none.
[[nodiscard]] std::string rejected_remark(const Metrics& metrics);
/// Says that the run ended before its time; empty where it did not.
[[nodiscard]] std::string interrupted_remark(const Metrics& metrics);
/// Says which figures of a very long run are approximate; empty where none is.
[[nodiscard]] std::string approximate_remark(const Metrics& metrics);

}  // namespace saccade
