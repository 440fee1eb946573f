#include "core/detector_factory.h"

#include <algorithm>

namespace saccade {

const std::vector<std::string>& detector_presets() {
  static const std::vector<std::string> names = {"paper_full", "paper_directed"};
  return names;
}

DetectorConfig detector_preset(const std::string& name) {
  DetectorConfig config;
  config.preset = name;
  config.hough.directed = name == "paper_directed";
  config.hough.threshold = config.hough.directed ? 0.3 : 1.0;
  if (!config.hough.directed && name != "paper_full") {
    throw InputError("detector preset", name, expectation_of(detector_presets()));
  }
  return config;
}

void describe(FieldVisitor& v, DetectorConfig& config) {
  const std::string preset = config.preset;
  v.choice("preset", config.preset, detector_presets(), "what the other keys start from");
  const auto& known = detector_presets();
  if (config.preset != preset && std::find(known.begin(), known.end(), config.preset) != known.end()) {
    config = detector_preset(config.preset);
  }
  describe(v, config.hough);
}

std::unique_ptr<Detector> make_detector(const DetectorConfig& config, const PinholeCamera& camera) {
  return std::make_unique<HoughDetector>(config.hough, camera.size);
}

}  // namespace saccade
