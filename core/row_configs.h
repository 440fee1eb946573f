#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "core/any_config.h"
#include "core/named_rows.h"

namespace saccade {

/// The configs of all rows of a registry, each with its defaults at first. Row has members `name` and `config`. Empty
/// when default constructed.
template <class Row>
class RowConfigs {
 public:
  RowConfigs() = default;
  explicit RowConfigs(NamedRows<Row> rows) : rows_(std::move(rows)) {
    for (const Row& row : rows_) configs_.push_back(row.config);
  }

  [[nodiscard]] const NamedRows<Row>& rows() const { return rows_; }
  /// Calls `visit(const Row&, AnyConfig&)` for each row, in order.
  template <class Visit>
  void for_each(const Visit& visit) {
    std::size_t i = 0;
    for (const Row& row : rows_) visit(row, configs_[i++]);
  }
  /// The config of the row with this name, which exists.
  [[nodiscard]] const AnyConfig& of(std::string_view name) const {
    std::size_t i = 0;
    while (i < configs_.size() && (rows_.begin() + static_cast<std::ptrdiff_t>(i))->name != name) ++i;
    SACCADE_CHECK(i < configs_.size());
    return configs_[i];
  }
  /// The first config struct of this type; nullptr where there is none.
  template <class Config>
  [[nodiscard]] Config* get_if() {
    for (AnyConfig& config : configs_) {
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
  NamedRows<Row> rows_;
  std::vector<AnyConfig> configs_;
};

}  // namespace saccade
