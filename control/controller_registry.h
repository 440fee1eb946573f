#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "control/gaze_controller.h"
#include "control/joint_limiter.h"
#include "core/registry_configs.h"

namespace saccade {

/// A kind of gaze controller. Made by controller_row().
struct GazeControllerRow {
  std::string name;  ///< value of the key `controller`, and name of the section with the keys of the config
  std::string description;  ///< one line, for lists
  TypeErasedConfig config;  ///< default values
  /// `limits` are those of the six joints of neck and eyes. Throws InputError for a configuration out of range.
  std::function<std::unique_ptr<GazeController>(const TypeErasedConfig&, const MotionLimits& limits)> make;
  /// False for a controller that moves the head by itself and ignores targets.
  bool follows_targets = true;
};

/// A row for controllers with this config struct. `make(const Config&, const MotionLimits&)` returns a std::unique_ptr to
/// the controller.
template <class Config, class Make>
[[nodiscard]] GazeControllerRow controller_row(std::string name, std::string description, Config defaults,
                                               Make make) {
  return row_of<GazeControllerRow>(std::move(name), std::move(description), std::move(defaults),
                                   std::move(make));
}

/// The gaze controller that a file configures, and how fast it may move. ControllerRegistry::config() gives the defaults;
/// a default constructed one has no controllers.
struct GazeControllerConfig : RegistryConfigs<GazeControllerRow> {
  std::string controller;  ///< name of a row
  MotionLimitsConfig limits;

  /// Whether the chosen controller looks at targets.
  [[nodiscard]] bool follows_targets() const;
};

/// Keys, beside each other in a scenario's gaze section: controller, the section of the chosen controller, limits.*.
void describe(FieldVisitor& v, GazeControllerConfig& config);

/// `hardware`: the limits of the head's joints. Throws InputError.
[[nodiscard]] std::unique_ptr<GazeController> make_gaze_controller(const GazeControllerConfig& config,
                                                                   const JointLimits& hardware);

/// The gaze controllers that a program offers.
class ControllerRegistry : public RowRegistry<GazeControllerRow> {
 public:
  /// The first controller, and the defaults of all.
  [[nodiscard]] GazeControllerConfig config() const;
};

/// The gaze controllers that saccade ships: qp, ikingaze, script.
[[nodiscard]] ControllerRegistry built_in_controllers();

}  // namespace saccade
