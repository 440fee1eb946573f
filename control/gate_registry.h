#pragma once

#include <functional>
#include <memory>
#include <string>

#include "control/gaze_gate.h"
#include "control/target.h"
#include "core/registry_configs.h"

namespace saccade {

/// A kind of gate. Made by gate_row().
struct GateRow {
  std::string name;         ///< value of the key `gate`; the section with the keys of the config is NAME_gate
  std::string description;  ///< one line, for lists
  TypeErasedConfig config;  ///< default values; NoKeys for a gate without a section
  /// Throws InputError for a configuration out of range.
  std::function<std::unique_ptr<GazeGate>(const TypeErasedConfig&, const TargetConfig&)> make;
};

/// A row for gates with this config struct. `make(const Config&, const TargetConfig&)` returns a std::unique_ptr to the
/// gate.
template <class Config, class Make>
[[nodiscard]] GateRow gate_row(std::string name, std::string description, Config defaults, Make make) {
  return row_of<GateRow>(std::move(name), std::move(description), std::move(defaults), std::move(make));
}

/// The gate that a file configures, and how it makes a point of a circle. GateRegistry::config() gives the defaults; a
/// default constructed one has no gates.
struct GateConfig : RegistryConfigs<GateRow> {
  std::string gate;  ///< name of a row
  TargetConfig target;
};

/// Keys, beside each other in a scenario's gaze section: gate, the sections of all gates (authors_gate.*,
/// continuity_gate.*), target.*.
void describe(FieldVisitor& v, GateConfig& config);

/// Throws InputError.
[[nodiscard]] std::unique_ptr<GazeGate> make_gate(const GateConfig& config);

/// The gates that a program offers.
class GateRegistry : public RowRegistry<GateRow> {
 public:
  /// `default_gate`, and the defaults of all gates.
  [[nodiscard]] GateConfig config() const;

  std::string default_gate;  ///< name of a row
};

/// The gates that saccade ships: none, authors, continuity (the default).
[[nodiscard]] GateRegistry built_in_gates();

}  // namespace saccade
