#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/scenario.h"

namespace saccade {

/// A detector that the window lists.
struct ViewDetector {
  std::string name;
  DetectorConfig config;
  bool enabled = true;
};

/// The configuration that a user can change while a loop runs.
struct ViewSettings {
  std::vector<ViewDetector> detectors;  ///< may be empty: a scenario may have none
  /// Index of the detector whose Hough space, score and configuration are shown, and which drives the gaze where there
  /// is gaze. It is always enabled. Without meaning while `detectors` is empty.
  std::size_t selected = 0;
  std::optional<GazeControllerConfig> controller;  ///< where the head is moved
  std::optional<GateConfig> gate;                  ///< where a detector drives the gaze

  /// Null where there are no detectors.
  [[nodiscard]] const ViewDetector* selected_detector() const {
    return selected < detectors.size() ? &detectors[selected] : nullptr;
  }
  [[nodiscard]] ViewDetector* selected_detector() {
    return selected < detectors.size() ? &detectors[selected] : nullptr;
  }
  /// "none" where there are no detectors, as `gaze.detector` has it.
  [[nodiscard]] std::string selected_name() const {
    return selected < detectors.size() ? detectors[selected].name : "none";
  }
  /// Index of the selected detector among the enabled ones, which are the loop's.
  [[nodiscard]] std::size_t selected_in_loop() const;
  /// The enabled detectors, in their order.
  [[nodiscard]] NamedDetectors enabled() const;
};

/// The settings of a scenario or of a command line: all detectors enabled. `selected` is a name; the first detector is
/// selected where none has that name.
[[nodiscard]] ViewSettings view_settings(const NamedDetectors& detectors, const std::string& selected);

}  // namespace saccade
