#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/hough_detector.h"

namespace saccade {

/// One detector as a configuration names it: a preset and what differs from it.
struct DetectorConfig {
  std::string preset = "paper_directed";
  HoughDetectorConfig hough;
};

/// paper_full, paper_directed (docs/detectors.md has their sources).
[[nodiscard]] const std::vector<std::string>& detector_presets();
/// Throws InputError for an unknown name.
[[nodiscard]] DetectorConfig detector_preset(const std::string& name);
/// Keys: preset, then those of the detector.
void describe(FieldVisitor& v, DetectorConfig& config);
/// Throws InputError for a configuration out of range.
[[nodiscard]] std::unique_ptr<Detector> make_detector(const DetectorConfig& config,
                                                      const PinholeCamera& camera);

}  // namespace saccade
