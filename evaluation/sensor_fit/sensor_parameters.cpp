#include "evaluation/sensor_fit/sensor_parameters.h"

#include <array>
#include <cmath>
#include <variant>

#include "core/error.h"

namespace saccade {
namespace {

using Member = std::variant<double EmulatorConfig::*, std::int64_t EmulatorConfig::*>;

struct Row {
  SensorParameter parameter;
  Member member;
};

const std::vector<Row>& rows() {
  using C = EmulatorConfig;
  static const std::vector<Row> all = {
      {{"contrast_threshold_on", Needs::contrast, 0.7, 0.02, 2.0}, &C::contrast_threshold_on},
      {{"contrast_threshold_off", Needs::contrast, 0.7, 0.02, 2.0}, &C::contrast_threshold_off},
      {{"threshold_mismatch", Needs::contrast, 1.0, 0.002, 0.4}, &C::threshold_mismatch},
      {{"cutoff_hz", Needs::change, 1.5, 3.0, 3e5}, &C::cutoff_hz},
      {{"refractory_us", Needs::change, 1.5, 5.0, 1e5}, &C::refractory_us},
      {{"leak_rate_hz", Needs::still, 2.0, 1e-4, 100.0}, &C::leak_rate_hz},
      {{"leak_spread_decades", Needs::still, 1.0, 0.005, 0.8}, &C::leak_spread_decades},
      {{"shot_noise_rate_hz", Needs::still, 2.0, 1e-4, 300.0}, &C::shot_noise_rate_hz},
      {{"latency_us", Needs::trigger, 1.5, 1.0, 1e5}, &C::latency_us},
  };
  return all;
}

const Row& row_of(const std::string& key) {
  for (const Row& row : rows()) {
    if (row.parameter.key == key) return row;
  }
  SACCADE_CHECK(false);
  return rows().front();
}

}  // namespace

std::span<const SensorParameter> sensor_parameters() {
  static const std::vector<SensorParameter> all = [] {
    std::vector<SensorParameter> parameters;
    for (const Row& row : rows()) parameters.push_back(row.parameter);
    return parameters;
  }();
  return all;
}

double parameter_of(const EmulatorConfig& config, const std::string& key) {
  return std::visit([&](auto member) { return static_cast<double>(config.*member); }, row_of(key).member);
}

void set_parameter(EmulatorConfig& config, const std::string& key, double value) {
  const Member& member = row_of(key).member;
  if (const auto* real = std::get_if<double EmulatorConfig::*>(&member)) {
    config.** real = value;
  } else {
    config.*std::get<std::int64_t EmulatorConfig::*>(member) = std::llround(value);
  }
}

}  // namespace saccade
