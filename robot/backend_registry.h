#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/event.h"
#include "core/registry_configs.h"
#include "head/head_state.h"
#include "recording/format_registry.h"
#include "robot/robot.h"

namespace saccade {

/// What a backend gets besides its own keys.
struct RobotContext {
  JointLimits limits;      ///< of the head, in addition to those of the robot
  ImageSize image_size;    ///< of the calibrated camera
  FormatRegistry formats;  ///< of recordings
};

/// A kind of robot. Made by backend_row().
struct RobotBackend {
  std::string name;  ///< value of the key `backend`, and name of the section with the keys of the config
  std::string description;  ///< one line, for lists
  TypeErasedConfig config;  ///< default values
  /// Connects to the robot. Throws InputError if this build has no such backend or the configuration is out of range,
  /// RunError if the robot does not answer.
  std::function<std::unique_ptr<Robot>(const TypeErasedConfig&, const RobotContext&)> open;
  /// Whether targets go to a gaze controller of the robot's own (Robot::gaze).
  std::function<bool(const TypeErasedConfig&)> has_gaze_controller;
  /// Name of the head that a configuration moves, the same for every process that can move it; empty without one.
  std::function<std::string(const TypeErasedConfig&)> head_name;
  /// Connects to the head alone, to stop it. Throws as open does. Empty if the backend has no such connection.
  std::function<std::unique_ptr<HeadStopper>(const TypeErasedConfig&, const RobotContext&)> open_stopper = {};
  std::vector<std::string> required = {};  ///< keys of the config without a default
};

/// A row for robots with this config struct. `open(const Config&, const RobotContext&)` returns a std::unique_ptr to the
/// robot. Functions `bool has_gaze_controller(const Config&)` and `std::string head_name(const Config&)` beside the config
/// are optional; without them there is no such controller, and no head that other processes can move.
template <class Config, class Open>
[[nodiscard]] RobotBackend backend_row(std::string name, std::string description, Config defaults,
                                       Open open) {
  const auto has_controller = [](const Config& config) {
    if constexpr (requires { has_gaze_controller(config); }) {
      return has_gaze_controller(config);
    } else {
      return false;
    }
  };
  const auto name_of_head = [](const Config& config) -> std::string {
    if constexpr (requires { head_name(config); }) {
      return head_name(config);
    } else {
      return {};
    }
  };
  return {std::move(name),
          std::move(description),
          TypeErasedConfig(std::move(defaults)),
          for_erased_config<Config>(std::move(open)),
          for_erased_config<Config>(has_controller),
          for_erased_config<Config>(name_of_head)};
}

/// The robot that a file configures. BackendRegistry::config() gives the defaults.
struct RobotBackendConfig : RegistryConfigs<RobotBackend> {
  std::string backend;  ///< name of a row

  /// Whether targets go to a gaze controller of the robot's own.
  [[nodiscard]] bool has_gaze_controller() const;
  /// RobotBackend::head_name of the chosen backend.
  [[nodiscard]] std::string head_name() const;
};

/// Keys, beside each other in a robot file: backend, the section of the chosen backend.
void describe(FieldVisitor& v, RobotBackendConfig& config);

/// Connects to the robot. Throws InputError, RunError.
[[nodiscard]] std::unique_ptr<Robot> open_robot(const RobotBackendConfig& config,
                                                const RobotContext& context);

/// Connects to the head of the robot, to stop it. Throws InputError also for a backend without such a connection; RunError.
[[nodiscard]] std::unique_ptr<HeadStopper> open_head_stopper(const RobotBackendConfig& config,
                                                             const RobotContext& context);

/// The backends that a program offers.
class BackendRegistry : public RowRegistry<RobotBackend> {
 public:
  /// The first backend, and the defaults of all.
  [[nodiscard]] RobotBackendConfig config() const;
};

}  // namespace saccade
