#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/ball_tracker.h"
#include "core/baselines/cluster.h"
#include "core/baselines/multi_kernel.h"
#include "core/baselines/original_2016.h"
#include "core/hough_detector.h"

namespace saccade {

/// One detector as a configuration names it: a preset and what differs from it.
struct DetectorConfig {
  std::string preset = "paper_directed";
  std::variant<HoughDetectorConfig, BallTrackerConfig, Original2016Config, ClusterConfig, MultiKernelConfig>
      detector;
};

/// Every preset there is (docs/detectors.md has their sources).
[[nodiscard]] const std::vector<std::string>& detector_presets();
/// Those that run where nobody says which.
[[nodiscard]] const std::vector<std::string>& default_detectors();
/// Throws InputError for an unknown name.
[[nodiscard]] DetectorConfig detector_preset(const std::string& name);
/// Keys: preset, then those of the detector.
void describe(FieldVisitor& v, DetectorConfig& config);
/// Throws InputError for a configuration out of range.
[[nodiscard]] std::unique_ptr<Detector> make_detector(const DetectorConfig& config, const Camera& camera);

}  // namespace saccade
