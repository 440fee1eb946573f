#include "apps/external/external_rows.h"

#include <filesystem>
#include <memory>

#include "apps/external/external_detector.h"

namespace saccade {
namespace {

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }
std::string name_of(const PythonDetectorConfig& config) { return file_name(config.python); }
std::string name_of(const CommandDetectorConfig& config) { return file_name(config.command); }

template <class Config>
void add_row(DetectorRegistry& registry, const std::string& name, const std::string& description) {
  DetectorRow row = detector_row(name, description, Config{}, [](const Config& config, const Camera& camera) {
    return std::make_unique<ExternalDetector>(name_of(config), command_line_of(config), config.limits,
                                              camera);
  });
  row.selecting_key = name;
  registry.add(std::move(row));
}

}  // namespace

void add_external_detectors(DetectorRegistry& registry) {
  add_row<PythonDetectorConfig>(registry, "python", "a detector of your own, a class in Python");
  add_row<CommandDetectorConfig>(registry, "command", "a detector of your own, a program");
}

}  // namespace saccade
