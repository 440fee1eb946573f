#include "control/gate_registry.h"

#include "control/continuity_gate.h"
#include "control/median_gate.h"
#include "control/open_gate.h"

namespace saccade {

void describe(FieldVisitor& v, GateConfig& config) {
  v.choice("gate", config.gate, config.rows().names(), "which detections become gaze targets");
  config.for_each([&](const GateRow& row, TypeErasedConfig& keys) {
    if (keys.get_if<NoKeys>() != nullptr) return;
    v.section(
        row.name + "_gate", [&](FieldVisitor& w) { describe(w, keys); }, row.description);
  });
  v.section(
      "target", [&](FieldVisitor& w) { describe(w, config.target); }, "conversion of a circle to a point");
}

std::unique_ptr<GazeGate> make_gate(const GateConfig& config) {
  check_config("gaze", config);
  const GateRow& row = *config.rows().find(config.gate);
  return row.make(config.of(row.name), config.target);
}

GateConfig GateRegistry::config() const {
  SACCADE_CHECK(rows().find(default_gate) != nullptr);
  return {RegistryConfigs<GateRow>(rows()), default_gate, {}};
}

GateRegistry built_in_gates() {
  GateRegistry registry;
  registry.add(
      gate_row("none", "every estimate at or above the threshold becomes a target", NoKeys{},
               [](const NoKeys&, const TargetConfig& target) { return std::make_unique<OpenGate>(target); }));
  registry.add(gate_row("authors", "median of many detections that agree, as in the demo of 2016",
                        MedianGateConfig{}, [](const MedianGateConfig& config, const TargetConfig& target) {
                          return std::make_unique<MedianGate>(config, target);
                        }));
  registry.add(gate_row("continuity", "detections near the last one, or confirmed by others",
                        ContinuityGateConfig{},
                        [](const ContinuityGateConfig& config, const TargetConfig& target) {
                          return std::make_unique<ContinuityGate>(config, target);
                        }));
  registry.default_gate = "continuity";
  return registry;
}

}  // namespace saccade
