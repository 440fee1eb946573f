#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/type_erased_config.h"

namespace saccade {

/// The rows of a registry, in the order in which they were added. Row has a member `name`. A copy is cheap and does not
/// change when rows are added to the original.
template <class Row>
class RegistryRows {
 public:
  /// Throws InputError for a name that another row has or that is_name refuses.
  void add(Row row) {
    if (!is_name(row.name)) {
      throw InputError("name of a row", row.name, std::string(name_expectation));
    }
    if (find(row.name) != nullptr) throw InputError("name of a row", row.name, "a name that no row has yet");
    auto longer = std::make_shared<std::vector<Row>>(*rows_);
    longer->push_back(std::move(row));
    rows_ = std::move(longer);
  }

  /// nullptr where no row has the name. Valid while this or a copy of it exists unchanged.
  [[nodiscard]] const Row* find(std::string_view name) const {
    const auto it =
        std::find_if(rows_->begin(), rows_->end(), [&](const Row& row) { return row.name == name; });
    return it != rows_->end() ? &*it : nullptr;
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Row& row : *rows_) names.push_back(row.name);
    return names;
  }
  [[nodiscard]] std::size_t size() const { return rows_->size(); }
  [[nodiscard]] auto begin() const { return rows_->begin(); }
  [[nodiscard]] auto end() const { return rows_->end(); }

 private:
  std::shared_ptr<const std::vector<Row>> rows_ = std::make_shared<std::vector<Row>>();
};

}  // namespace saccade
