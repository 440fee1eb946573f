#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/detector.h"
#include "core/registry_rows.h"
#include "core/type_erased_config.h"

namespace saccade {

/// A kind of detector: a class of detectors with default values. Made by detector_row().
struct DetectorRow {
  std::string name;         ///< value of the key `preset`; is_name
  std::string description;  ///< one line, for lists
  TypeErasedConfig config;  ///< default values
  /// Throws InputError for a configuration out of range.
  std::function<std::unique_ptr<Detector>(const TypeErasedConfig&, const Camera&)> make;
  /// The events that the estimate is made of, such as "1500 events" or "20 ms"; empty without a fixed window.
  std::function<std::string(const TypeErasedConfig&)> window;
  /// Key of the config that selects this row where an entry has no `preset`; empty: none does.
  std::string selecting_key = {};
  /// The field of the key `threshold`; nullptr where there is none.
  double* (*threshold)(TypeErasedConfig&) = nullptr;
};

/// A row for detectors with this config struct. `make(const Config&, const Camera&)` returns a std::unique_ptr to the
/// detector. `window` of the row comes from a function `std::string window_text(const Config&)` beside the struct, where
/// there is one, `threshold` from a member `double threshold`.
template <class Config, class Make>
[[nodiscard]] DetectorRow detector_row(std::string name, std::string description, Config defaults,
                                       Make make) {
  DetectorRow row{std::move(name),
                  std::move(description),
                  TypeErasedConfig(std::move(defaults)),
                  for_erased_config<Config>(std::move(make)),
                  {},
                  {},
                  nullptr};
  if constexpr (requires(const Config& config) { window_text(config); }) {
    row.window = [](const TypeErasedConfig& config) -> std::string {
      return window_text(config.get<Config>());
    };
  }
  if constexpr (requires(Config & config) { config.threshold; }) {
    row.threshold = [](TypeErasedConfig& config) { return &config.get<Config>().threshold; };
  }
  return row;
}

/// One detector as a file configures it: the name of its row and the values of its keys. A value; an empty one (default
/// constructed) only stands for a config that is assigned later.
class DetectorConfig {
 public:
  DetectorConfig() = default;

  /// Name of the row that the defaults came from.
  [[nodiscard]] const std::string& preset() const;
  /// The config struct if it is of this type, else nullptr.
  template <class Config>
  [[nodiscard]] Config* get_if() {
    return config_.get_if<Config>();
  }
  template <class Config>
  [[nodiscard]] const Config* get_if() const {
    return config_.get_if<Config>();
  }
  /// The config struct, which is of this type.
  template <class Config>
  [[nodiscard]] Config& get() {
    return config_.get<Config>();
  }
  template <class Config>
  [[nodiscard]] const Config& get() const {
    return config_.get<Config>();
  }
  /// The events that the estimate is made of, such as "1500 events" or "20 ms"; empty without a fixed window.
  [[nodiscard]] std::string window() const;
  /// Multiplies the key `threshold`. False, and nothing changes, where there is none or the product is out of range.
  bool scale_threshold(double factor);

  /// Keys: preset, then those of the detector. A value of `preset` other than the current one sets all keys to the
  /// defaults of that row.
  friend void describe(FieldVisitor& v, DetectorConfig& config);
  /// Throws InputError for a configuration out of range.
  friend std::unique_ptr<Detector> make_detector(const DetectorConfig& config, const Camera& camera);

 private:
  friend class DetectorRegistry;
  DetectorConfig(RegistryRows<DetectorRow> rows, std::string preset);
  [[nodiscard]] const DetectorRow& row() const;

  RegistryRows<DetectorRow> rows_;
  std::string preset_;
  TypeErasedConfig config_{NoKeys{}};
};

[[nodiscard]] std::unique_ptr<Detector> make_detector(const DetectorConfig& config, const Camera& camera);

/// The detectors that a program offers, by the names of their presets. A value: main builds it and passes it on.
class DetectorRegistry {
 public:
  /// Throws InputError for a name that another row has or that is_name refuses, and for `none`.
  void add(DetectorRow row);
  [[nodiscard]] const RegistryRows<DetectorRow>& rows() const { return rows_; }
  [[nodiscard]] std::vector<std::string> names() const { return rows_.names(); }
  [[nodiscard]] bool has(std::string_view name) const { return rows_.find(name) != nullptr; }
  /// The default configuration of a row. Throws InputError for a name that no row has.
  [[nodiscard]] DetectorConfig config(const std::string& name) const;

  /// Detectors that run where no file says which.
  std::vector<std::string> defaults;

 private:
  RegistryRows<DetectorRow> rows_;
};

}  // namespace saccade
