#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace saccade {

/// The closed range a number may lie in, in the unit of its key.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool contains(double value) const { return value >= min && value <= max; }  // false for NaN
};

/// How a module tells the keys, units, ranges and meaning of its configuration, once, in a function
///
///     void describe(FieldVisitor& v, ObjectConfig& config);
///
/// beside its plain config struct. Reading a scenario, writing the resolved one, checking in a
/// constructor and printing help are visitors; no module knows YAML. Keys end in their unit.
class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  virtual void real(std::string_view key, double& value, Range range, std::string_view doc) = 0;
  virtual void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) = 0;
  virtual void boolean(std::string_view key, bool& value, std::string_view doc) = 0;
  virtual void text(std::string_view key, std::string& value, std::string_view doc) = 0;
  /// One word out of `options`.
  virtual void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
                      std::string_view doc) = 0;
  /// A list of numbers, each in `range`; `size` elements, or any number of them where it is 0.
  virtual void reals(std::string_view key, std::vector<double>& value, std::size_t size, Range range,
                     std::string_view doc) = 0;
  /// A list of points of `dimension` numbers each, in `range`.
  virtual void points(std::string_view key, std::vector<std::vector<double>>& value, std::size_t dimension,
                      Range range, std::string_view doc) = 0;
  /// A block of keys of its own.
  virtual void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
                       std::string_view doc) = 0;
  /// A condition over several keys. `key` names the one to blame, `found` what it holds.
  virtual void require(bool holds, std::string_view key, std::string_view found,
                       std::string_view expectation) = 0;
};

/// Checks a config struct against what its `describe` says; used by constructors.
/// Throws InputError whose places are `name.key`.
class FieldChecker final : public FieldVisitor {
 public:
  explicit FieldChecker(std::string name) : name_(std::move(name)) {}

  void real(std::string_view key, double& value, Range range, std::string_view doc) override;
  void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) override;
  void boolean(std::string_view, bool&, std::string_view) override {}
  void text(std::string_view, std::string&, std::string_view) override {}
  void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
              std::string_view doc) override;
  void reals(std::string_view key, std::vector<double>& value, std::size_t size, Range range,
             std::string_view doc) override;
  void points(std::string_view key, std::vector<std::vector<double>>& value, std::size_t dimension,
              Range range, std::string_view doc) override;
  void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
               std::string_view doc) override;
  void require(bool holds, std::string_view key, std::string_view found,
               std::string_view expectation) override;

  [[nodiscard]] bool passed() const { return problems_.empty(); }
  void throw_if_any() const;

 private:
  void add(std::string_view key, std::string value, std::string expectation);

  std::string name_;
  std::vector<Problem> problems_;
};

/// Throws InputError where `config` breaks what describe(FieldVisitor&, Config&) says of it.
template <class Config>
void check_config(std::string_view name, const Config& config) {
  FieldChecker checker{std::string(name)};
  Config copy = config;
  describe(checker, copy);
  checker.throw_if_any();
}

/// The sentences shared by every visitor that complains: "a number in [0, 1]", "one of a, b, c".
[[nodiscard]] std::string expectation_of(Range range, std::string_view kind);
[[nodiscard]] std::string expectation_of(const std::vector<std::string>& options);
/// The shortest decimal text that reads back as the same double.
[[nodiscard]] std::string text_of(double value);

}  // namespace saccade
