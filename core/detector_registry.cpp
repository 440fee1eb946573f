#include "core/detector_registry.h"

namespace saccade {

DetectorConfig::DetectorConfig(RegistryRows<DetectorRow> rows, std::string preset)
    : rows_(std::move(rows)), preset_(std::move(preset)), config_(row().config) {}

const DetectorRow& DetectorConfig::row() const {
  const DetectorRow* const row = rows_.find(preset_);
  SACCADE_CHECK(row != nullptr);
  return *row;
}

const std::string& DetectorConfig::preset() const { return preset_; }

std::string DetectorConfig::window() const {
  const DetectorRow& r = row();
  return r.window ? r.window(config_) : std::string{};
}

bool DetectorConfig::scale_threshold(double factor) {
  if (row().threshold == nullptr) return false;
  TypeErasedConfig scaled = config_;
  *row().threshold(scaled) *= factor;
  FieldChecker checker("detector");
  describe(checker, scaled);
  if (checker.passed()) config_ = std::move(scaled);
  return checker.passed();
}

void describe(FieldVisitor& v, DetectorConfig& config) {
  std::string preset = config.preset_;
  v.choice("preset", preset, config.rows_.names(),
           "detector whose values are the defaults of the other keys");
  if (preset != config.preset_ && config.rows_.find(preset) != nullptr) {
    config = DetectorConfig(config.rows_, preset);
  }
  describe(v, config.config_);
}

std::unique_ptr<Detector> make_detector(const DetectorConfig& config, const Camera& camera) {
  return config.row().make(config.config_, camera);
}

void DetectorRegistry::add(DetectorRow row) {
  if (row.name == "none")
    throw InputError("name of a row", row.name, "another name: this one stands for no detector");
  rows_.add(std::move(row));
}

DetectorConfig DetectorRegistry::config(const std::string& name) const {
  if (!has(name)) throw InputError("detector preset", name, expectation_of(names()));
  return {rows_, name};
}

}  // namespace saccade
