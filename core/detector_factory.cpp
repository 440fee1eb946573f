#include "core/detector_factory.h"

#include <algorithm>

namespace saccade {
namespace {

struct Preset {
  std::string name;
  decltype(DetectorConfig::detector) detector;
};

HoughDetectorConfig hough(bool directed, double threshold) {
  HoughDetectorConfig config;
  config.directed = directed;
  config.threshold = threshold;
  return config;
}

const std::vector<Preset>& presets() {
  static const std::vector<Preset> all = [] {
    HoughDetectorConfig lifetime = hough(true, 0.6);
    lifetime.window = event_window("lifetime");
    HoughDetectorConfig single_radius = hough(false, 1.0);
    single_radius.single_radius = true;
    return std::vector<Preset>{
        {"paper_full", hough(false, 1.0)}, {"paper_directed", hough(true, 0.3)},
        {"best", BallTrackerConfig{}},     {"lifetime", lifetime},
        {"single_radius", single_radius},  {"original_2016", Original2016Config{}},
        {"cluster", ClusterConfig{}},      {"multi_kernel", MultiKernelConfig{}},
    };
  }();
  return all;
}

const Preset* find(const std::string& name) {
  const auto it = std::find_if(presets().begin(), presets().end(),
                               [&](const Preset& preset) { return preset.name == name; });
  return it != presets().end() ? &*it : nullptr;
}

std::unique_ptr<Detector> make(const HoughDetectorConfig& config, const Camera& camera) {
  return std::make_unique<HoughDetector>(config, camera.size);
}
std::unique_ptr<Detector> make(const BallTrackerConfig& config, const Camera& camera) {
  return std::make_unique<BallTracker>(config, camera);
}
std::unique_ptr<Detector> make(const Original2016Config& config, const Camera& camera) {
  return std::make_unique<Original2016>(config, camera.size);
}
std::unique_ptr<Detector> make(const ClusterConfig& config, const Camera& camera) {
  return std::make_unique<ClusterDetector>(config, camera.size);
}
std::unique_ptr<Detector> make(const MultiKernelConfig& config, const Camera& camera) {
  return std::make_unique<MultiKernelDetector>(config, camera.size);
}

}  // namespace

const std::vector<std::string>& detector_presets() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Preset& preset : presets()) all.push_back(preset.name);
    return all;
  }();
  return names;
}

const std::vector<std::string>& default_detectors() {
  static const std::vector<std::string> names = {"paper_full", "paper_directed", "best"};
  return names;
}

DetectorConfig detector_preset(const std::string& name) {
  const Preset* preset = find(name);
  if (preset == nullptr) throw InputError("detector preset", name, expectation_of(detector_presets()));
  return {name, preset->detector};
}

void describe(FieldVisitor& v, DetectorConfig& config) {
  const std::string before = config.preset;
  v.choice("preset", config.preset, detector_presets(), "what the other keys start from");
  if (config.preset != before && find(config.preset) != nullptr) config = detector_preset(config.preset);
  std::visit([&](auto& detector) { describe(v, detector); }, config.detector);
}

std::unique_ptr<Detector> make_detector(const DetectorConfig& config, const Camera& camera) {
  return std::visit([&](const auto& detector) { return make(detector, camera); }, config.detector);
}

}  // namespace saccade
