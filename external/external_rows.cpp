#include "external/external_rows.h"

#include <filesystem>
#include <memory>

#include "external/external_controller.h"
#include "external/external_detector.h"

namespace saccade {
namespace {

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }
std::string name_of(const PythonConfig& config) { return file_name(config.python); }
std::string name_of(const CommandConfig& config) { return file_name(config.command); }
std::string name_of(const SocketConfig& config) { return config.socket; }

// `section` goes before the key in messages.
LineProcess::Place place_of(const PythonConfig& config, const std::string& section = "") {
  return program_call(config, section);
}
LineProcess::Place place_of(const CommandConfig& config, const std::string& section = "") {
  return program_call(config, section);
}
LineProcess::Place place_of(const SocketConfig& config, const std::string& /*section*/ = "") {
  return address_of(config);
}

template <class Config>
void add_controller(ControllerRegistry& registry, const std::string& name, const std::string& description) {
  registry.add(
      controller_row(name, description, Config{},
                     [section = "gaze." + name + "."](const Config& config, const MotionLimits& limits) {
                       return std::make_unique<ExternalController>(name_of(config), place_of(config, section),
                                                                   config.limits, limits);
                     }));
}

template <class Config>
void add_row(DetectorRegistry& registry, const std::string& name, const std::string& description) {
  DetectorRow row = detector_row(name, description, Config{}, [](const Config& config, const Camera& camera) {
    return std::make_unique<ExternalDetector>(name_of(config), place_of(config), config.limits, camera);
  });
  row.selecting_key = name;
  registry.add(std::move(row));
}

}  // namespace

void add_external_detectors(DetectorRegistry& registry) {
  add_row<PythonConfig>(registry, "python", "a detector of your own, a class in Python");
  add_row<CommandConfig>(registry, "command", "a detector of your own, a program");
  add_row<SocketConfig>(registry, "socket", "a detector of your own, a program that listens");
}

void add_external_controllers(ControllerRegistry& registry) {
  add_controller<PythonConfig>(registry, "python", "a gaze controller of your own, a class in Python");
  add_controller<CommandConfig>(registry, "command", "a gaze controller of your own, a program");
  add_controller<SocketConfig>(registry, "socket", "a gaze controller of your own, a program that listens");
}

}  // namespace saccade
