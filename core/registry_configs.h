#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "core/registry_rows.h"
#include "core/type_erased_config.h"

namespace saccade {

/// The configs of all rows of a registry, each with its defaults at first. Row has members `name` and `config`. Empty
/// when default constructed.
template <class Row>
class RegistryConfigs {
 public:
  RegistryConfigs() = default;
  explicit RegistryConfigs(RegistryRows<Row> rows) : rows_(std::move(rows)) {
    for (const Row& row : rows_) configs_.push_back(row.config);
  }

  [[nodiscard]] const RegistryRows<Row>& rows() const { return rows_; }
  /// Calls `visit(const Row&, TypeErasedConfig&)` for each row, in order.
  template <class Visit>
  void for_each(const Visit& visit) {
    std::size_t i = 0;
    for (const Row& row : rows_) visit(row, configs_[i++]);
  }
  /// The config of the row with this name, which exists.
  [[nodiscard]] const TypeErasedConfig& of(std::string_view name) const {
    std::size_t i = 0;
    while (i < configs_.size() && (rows_.begin() + static_cast<std::ptrdiff_t>(i))->name != name) ++i;
    SACCADE_CHECK(i < configs_.size());
    return configs_[i];
  }
  /// The first config struct of this type; nullptr where there is none.
  template <class Config>
  [[nodiscard]] Config* get_if() {
    for (TypeErasedConfig& config : configs_) {
      if (Config* const found = config.template get_if<Config>()) return found;
    }
    return nullptr;
  }
  /// The first config struct of this type, which exists.
  template <class Config>
  [[nodiscard]] Config& get() {
    Config* const found = get_if<Config>();
    SACCADE_CHECK(found != nullptr);
    return *found;
  }

 private:
  RegistryRows<Row> rows_;
  std::vector<TypeErasedConfig> configs_;
};

/// Key `key`, which chooses a row, and a section with the keys of the chosen row under the row's name.
template <class Row>
void describe_chosen_row(FieldVisitor& v, std::string_view key, std::string& name,
                         RegistryConfigs<Row>& configs, std::string_view doc) {
  v.choice(key, name, configs.rows().names(), doc);
  configs.for_each([&](const Row& row, TypeErasedConfig& keys) {
    if (row.name == name) v.section(row.name, keys, row.description);
  });
}

/// The rows of one kind that a program offers. A value: main builds it and passes it on.
template <class Row>
class RowRegistry {
 public:
  /// Throws InputError for a name that another row has or that is_name refuses.
  void add(Row row) { rows_.add(std::move(row)); }
  [[nodiscard]] const RegistryRows<Row>& rows() const { return rows_; }

 private:
  RegistryRows<Row> rows_;
};

/// A row with name, description, default config and `make`, whose first parameter is the config struct.
template <class Row, class Config, class Make>
[[nodiscard]] Row row_of(std::string name, std::string description, Config defaults, Make make) {
  return {std::move(name), std::move(description), TypeErasedConfig(std::move(defaults)),
          for_erased_config<Config>(std::move(make))};
}

}  // namespace saccade
