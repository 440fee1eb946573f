#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/config.h"

namespace saccade {

/// The keys of a config struct with their values, read through its `describe`.
///
///     KeyValues keys;
///     describe(keys, config);
///     keys.has("window.events");
class KeyValues final : public FieldVisitor {
 public:
  /// Whether there is a key or a section at this path, such as "window" or "window.events".
  [[nodiscard]] bool has(std::string_view path) const { return numbers_.find(path) != numbers_.end(); }
  /// The numbers of a key, points one after the other; empty for a key of another kind, a section, and where there is none.
  [[nodiscard]] std::vector<double> numbers(std::string_view path) const;

  void real(std::string_view key, double& value, Range, std::string_view) override { add(key, {value}); }
  void integer(std::string_view key, std::int64_t& value, Range, std::string_view) override {
    add(key, {static_cast<double>(value)});
  }
  void boolean(std::string_view key, bool&, std::string_view) override { add(key, {}); }
  void text(std::string_view key, std::string&, std::string_view) override { add(key, {}); }
  void choice(std::string_view key, std::string&, const std::vector<std::string>&,
              std::string_view) override {
    add(key, {});
  }
  void numbers(std::string_view key, std::span<double> values, Range, std::string_view) override {
    add(key, {values.begin(), values.end()});
  }
  void point_list(std::string_view key, std::vector<double>& values, std::size_t, Range,
                  std::string_view) override {
    add(key, values);
  }
  void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
               std::string_view) override;
  void require(bool, std::string_view, std::string_view, std::string_view) override {}

 private:
  void add(std::string_view key, std::vector<double> values) {
    numbers_[prefix_ + std::string(key)] = std::move(values);
  }

  std::string prefix_;
  std::map<std::string, std::vector<double>, std::less<>> numbers_;  // by path
};

}  // namespace saccade
