#include "control/controller_registry.h"

#include "control/ikingaze_controller.h"
#include "control/qp_controller.h"
#include "control/script_controller.h"

namespace saccade {

bool GazeControllerConfig::follows_targets() const {
  const GazeControllerRow* const row = rows().find(controller);
  return row == nullptr || row->follows_targets;
}

void describe(FieldVisitor& v, GazeControllerConfig& config) {
  describe_chosen_row(v, "controller", config.controller, config, "gaze controller");
  v.section(
      "limits", [&](FieldVisitor& w) { describe(w, config.limits); },
      "limits of the references that move the head");
}

std::unique_ptr<GazeController> make_gaze_controller(const GazeControllerConfig& config,
                                                     const JointLimits& hardware) {
  check_config("gaze", config);
  const GazeControllerRow& row = *config.rows().find(config.controller);
  return row.make(config.of(row.name), motion_limits(hardware, config.limits));
}

GazeControllerConfig ControllerRegistry::config() const {
  SACCADE_CHECK(rows().size() > 0);
  return {RegistryConfigs<GazeControllerRow>(rows()), rows().begin()->name, {}};
}

ControllerRegistry built_in_controllers() {
  ControllerRegistry registry;
  registry.add(controller_row("qp", "bounded velocity inverse kinematics", QpConfig{},
                              [](const QpConfig& config, const MotionLimits& limits) {
                                return std::make_unique<QpController>(config, limits);
                              }));
  registry.add(controller_row("ikingaze", "the iCub's own controller", IkinGazeConfig{},
                              [](const IkinGazeConfig& config, const MotionLimits& limits) {
                                return std::make_unique<IkinGazeController>(config, limits);
                              }));
  GazeControllerRow script =
      controller_row("script", "a fixed sequence of positions of eyes and neck", ScriptConfig{},
                     [](const ScriptConfig& config, const MotionLimits& limits) {
                       return std::make_unique<ScriptController>(config, limits);
                     });
  script.follows_targets = false;
  registry.add(std::move(script));
  return registry;
}

}  // namespace saccade
