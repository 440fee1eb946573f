#pragma once

#include <functional>
#include <memory>
#include <string>

#include "control/gaze_gate.h"
#include "control/target.h"
#include "core/any_config.h"
#include "core/named_rows.h"
#include "core/row_configs.h"

namespace saccade {

/// A kind of gate. Made by gate_row().
struct GateRow {
  std::string name;         ///< value of the key `gate`; the section with the keys of the config is NAME_gate
  std::string description;  ///< one line, for lists
  AnyConfig config;         ///< default values; NoKeys for a gate without a section
  /// Throws InputError for a configuration out of range.
  std::function<std::unique_ptr<GazeGate>(const AnyConfig&, const TargetConfig&)> make;
};

/// A row for gates with this config struct. `make(const Config&, const TargetConfig&)` returns a std::unique_ptr to the
/// gate.
template <class Config, class Make>
[[nodiscard]] GateRow gate_row(std::string name, std::string description, Config defaults, Make make) {
  return {std::move(name), std::move(description), AnyConfig(std::move(defaults)),
          for_any_config<Config>(std::move(make))};
}

/// The gate that a file configures, and how it makes a point of a circle. GateRegistry::config() gives the defaults; a
/// default constructed one has no gates.
struct GateConfig {
  std::string gate;             ///< name of a row
  RowConfigs<GateRow> configs;  ///< of every gate
  TargetConfig target;

  /// The config struct of this type, which one of the gates has.
  template <class Config>
  [[nodiscard]] Config& get() {
    return configs.get<Config>();
  }
};

/// Keys, beside each other in a scenario's gaze section: gate, the sections of all gates (authors_gate.*,
/// continuity_gate.*), target.*.
void describe(FieldVisitor& v, GateConfig& config);

/// Throws InputError.
[[nodiscard]] std::unique_ptr<GazeGate> make_gate(const GateConfig& config);

/// The gates that a program offers. A value: main builds it and passes it on.
class GateRegistry {
 public:
  /// Throws InputError for a name that another row has or that is_name refuses.
  void add(GateRow row) { rows_.add(std::move(row)); }
  [[nodiscard]] const NamedRows<GateRow>& rows() const { return rows_; }
  /// `default_gate`, and the defaults of all gates.
  [[nodiscard]] GateConfig config() const;

  std::string default_gate;  ///< name of a row

 private:
  NamedRows<GateRow> rows_;
};

/// The gates that saccade ships: none, authors, continuity (the default).
[[nodiscard]] GateRegistry built_in_gates();

}  // namespace saccade
