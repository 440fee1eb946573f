#include "control/controller_registry.h"

#include "control/ikingaze_controller.h"
#include "control/qp_controller.h"
#include "control/script_controller.h"

namespace saccade {

bool GazeControllerConfig::follows_targets() const {
  const GazeControllerRow* const row = configs.rows().find(controller);
  return row == nullptr || row->follows_targets;
}

void describe(FieldVisitor& v, GazeControllerConfig& config) {
  v.choice("controller", config.controller, config.configs.rows().names(), "what moves the head");
  config.configs.for_each([&](const GazeControllerRow& row, AnyConfig& keys) {
    if (row.name != config.controller) return;
    v.section(
        row.name, [&](FieldVisitor& w) { describe(w, keys); }, row.description);
  });
  v.section(
      "limits", [&](FieldVisitor& w) { describe(w, config.limits); }, "how fast gaze may move");
}

std::unique_ptr<GazeController> make_gaze_controller(const GazeControllerConfig& config,
                                                     const JointLimits& hardware) {
  check_config("gaze", config);
  const GazeControllerRow& row = *config.configs.rows().find(config.controller);
  return row.make(config.configs.of(row.name), motion_limits(hardware, config.limits));
}

GazeControllerConfig ControllerRegistry::config() const {
  SACCADE_CHECK(rows_.size() > 0);
  return {rows_.begin()->name, RowConfigs<GazeControllerRow>(rows_), {}};
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
