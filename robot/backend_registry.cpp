#include "robot/backend_registry.h"

namespace saccade {

bool RobotBackendConfig::has_gaze_controller() const {
  const RobotBackend* const row = rows().find(backend);
  return row != nullptr && row->has_gaze_controller(of(backend));
}

std::string RobotBackendConfig::head_name() const {
  const RobotBackend* const row = rows().find(backend);
  return row != nullptr && row->head_name ? row->head_name(of(backend)) : std::string();
}

void describe(FieldVisitor& v, RobotBackendConfig& config) {
  describe_chosen_row(v, "backend", config.backend, config, "robot, or what replaces it");
}

std::unique_ptr<Robot> open_robot(const RobotBackendConfig& config, const RobotContext& context) {
  check_config("robot", config);
  return config.rows().find(config.backend)->open(config.of(config.backend), context);
}

std::unique_ptr<HeadStopper> open_head_stopper(const RobotBackendConfig& config,
                                               const RobotContext& context) {
  check_config("robot", config);
  const RobotBackend& row = *config.rows().find(config.backend);
  if (!row.open_stopper || config.head_name().empty())
    throw InputError("backend", config.backend, "a backend whose head another process can stop");
  return row.open_stopper(config.of(config.backend), context);
}

RobotBackendConfig BackendRegistry::config() const {
  SACCADE_CHECK(rows().size() > 0);
  return {RegistryConfigs<RobotBackend>(rows()), rows().begin()->name};
}

}  // namespace saccade
