#pragma once

#include <span>
#include <string>
#include <vector>

#include "emulator/emulator_config.h"

namespace saccade {

/// What a stimulus must have for a parameter to leave a trace in its recording.
enum class Needs {
  contrast,  ///< a change of light of known size
  change,    ///< a change of light
  trigger,   ///< a change of light at a known time
  still,     ///< a scene at rest
};

/// A parameter of the emulator that is fitted: by the logarithm of its value.
struct SensorParameter {
  std::string key;  ///< of EmulatorConfig
  Needs needs = Needs::change;
  double prior_deviation = 1.0;  ///< standard deviation of the logarithm around the prior's value
  double smallest = 0.0;
  double largest = 0.0;
};

[[nodiscard]] std::span<const SensorParameter> sensor_parameters();
[[nodiscard]] double parameter_of(const EmulatorConfig& config, const std::string& key);
/// Whole numbers are rounded.
void set_parameter(EmulatorConfig& config, const std::string& key, double value);

}  // namespace saccade
