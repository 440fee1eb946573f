#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "control/gaze_controller.h"
#include "control/joint_limiter.h"
#include "core/any_config.h"
#include "core/named_rows.h"
#include "core/row_configs.h"

namespace saccade {

/// A kind of gaze controller. Made by controller_row().
struct GazeControllerRow {
  std::string name;  ///< value of the key `controller`, and name of the section with the keys of the config
  std::string description;  ///< one line, for lists
  AnyConfig config;         ///< default values
  /// `limits` are those of the six joints of neck and eyes. Throws InputError for a configuration out of range.
  std::function<std::unique_ptr<GazeController>(const AnyConfig&, const MotionLimits& limits)> make;
  /// False for a controller that moves the head by itself and ignores targets.
  bool follows_targets = true;
};

/// A row for controllers with this config struct. `make(const Config&, const MotionLimits&)` returns a std::unique_ptr to
/// the controller.
template <class Config, class Make>
[[nodiscard]] GazeControllerRow controller_row(std::string name, std::string description, Config defaults,
                                               Make make) {
  return {std::move(name), std::move(description), AnyConfig(std::move(defaults)),
          for_any_config<Config>(std::move(make))};
}

/// The gaze controller that a file configures, and how fast it may move. ControllerRegistry::config() gives the defaults;
/// a default constructed one has no controllers.
struct GazeControllerConfig {
  std::string controller;                 ///< name of a row
  RowConfigs<GazeControllerRow> configs;  ///< of every controller
  MotionLimitsConfig limits;

  /// The config struct of this type, which one of the controllers has.
  template <class Config>
  [[nodiscard]] Config& get() {
    return configs.get<Config>();
  }
  /// Whether the chosen controller looks at targets.
  [[nodiscard]] bool follows_targets() const;
};

/// Keys, beside each other in a scenario's gaze section: controller, the section of the chosen controller, limits.*.
void describe(FieldVisitor& v, GazeControllerConfig& config);

/// `hardware`: the limits of the head's joints. Throws InputError.
[[nodiscard]] std::unique_ptr<GazeController> make_gaze_controller(const GazeControllerConfig& config,
                                                                   const JointLimits& hardware);

/// The gaze controllers that a program offers. A value: main builds it and passes it on.
class ControllerRegistry {
 public:
  /// Throws InputError for a name that another row has or that is_name refuses.
  void add(GazeControllerRow row) { rows_.add(std::move(row)); }
  [[nodiscard]] const NamedRows<GazeControllerRow>& rows() const { return rows_; }
  /// The first controller, and the defaults of all.
  [[nodiscard]] GazeControllerConfig config() const;

 private:
  NamedRows<GazeControllerRow> rows_;
};

/// The gaze controllers that saccade ships: qp, ikingaze, script.
[[nodiscard]] ControllerRegistry built_in_controllers();

}  // namespace saccade
