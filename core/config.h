#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"

namespace saccade {

struct ModelFile;

/// The closed range of a number, in the unit of its key.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool contains(double value) const { return value >= min && value <= max; }  // false for NaN
};

/// A value of an enumeration and its word in YAML. Beside an enumeration that a configuration holds stands
///
///     enum class Shape { box, cylinder };
///     constexpr auto words_of(Shape) {
///       return std::to_array<Word<Shape>>({{Shape::box, "box"}, {Shape::cylinder, "cylinder"}});
///     }
template <class Enum>
struct Word {
  Enum value;
  std::string_view word;
};

/// The word of an enumeration's value; empty for a value without one.
template <class Enum>
requires std::is_enum_v<Enum>
[[nodiscard]] constexpr std::string_view word_of(Enum value) {
  for (const auto& [known, word] : words_of(value)) {
    if (known == value) return word;
  }
  return {};
}

/// Visits the keys of a configuration. A module describes its plain config struct once, in a function
///
///     void describe(FieldVisitor& v, ObjectConfig& config);
///
/// beside the struct: keys (the unit is the last word of the key), ranges and meaning. Reading YAML, writing the
/// resolved scenario, the check in a constructor, the window's widgets and `saccade keys` are visitors. Only config
/// uses YAML.
class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  // One value.
  virtual void real(std::string_view key, double& value, Range range, std::string_view doc) = 0;
  virtual void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) = 0;
  virtual void boolean(std::string_view key, bool& value, std::string_view doc) = 0;
  virtual void text(std::string_view key, std::string& value, std::string_view doc) = 0;
  /// The path of a file or folder. A reader makes it absolute: in a file it is relative to the file's folder.
  virtual void path(std::string_view key, std::string& value, std::string_view doc) { text(key, value, doc); }
  /// The file of a fitted model. A reader reads it.
  virtual void model(std::string_view key, ModelFile& file, std::string_view doc);
  /// A program: a path as above, or the name of a program in PATH where there is no such file.
  virtual void program(std::string_view key, std::string& value, std::string_view doc) {
    text(key, value, doc);
  }
  /// One of words that are known only at run time, such as names of detectors.
  virtual void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
                      std::string_view doc) = 0;
  /// One value of an enumeration with words_of().
  template <class Enum>
  requires std::is_enum_v<Enum>
  void choice(std::string_view key, Enum& value, std::string_view doc);

  // Several numbers.
  /// A fixed count of numbers, each in `range`.
  virtual void numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) = 0;
  /// The same for std::array<double, N> and fixed Eigen vectors.
  template <class Values>
  requires std::is_same_v<decltype(std::declval<Values&>().data()), double*>
  void reals(std::string_view key, Values& values, Range range, std::string_view doc) {
    numbers(key, std::span<double>(values.data(), sizeof(Values) / sizeof(double)), range, doc);
  }
  /// Any count of points of `dimension` numbers each, which lie in `values` one after the other.
  virtual void point_list(std::string_view key, std::vector<double>& values, std::size_t dimension,
                          Range range, std::string_view doc) = 0;
  /// The same for lists of std::array<double, N> and of fixed Eigen vectors.
  template <class Point>
  void points(std::string_view key, std::vector<Point>& points, Range range, std::string_view doc);

  // Blocks of keys.
  virtual void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
                       std::string_view doc) = 0;
  /// The keys of a config struct that has a describe().
  template <class Config>
  requires requires(FieldVisitor& v, Config& config) { describe(v, config); }
  void section(std::string_view key, Config& config, std::string_view doc) {
    section(
        key, [&config](FieldVisitor& v) { describe(v, config); }, doc);
  }
  /// A section that may be absent.
  template <class Config>
  void optional_section(std::string_view key, std::optional<Config>& config, std::string_view doc);
  /// A section that holds one section per name, in the order of the file. `make(name)` gives the defaults of an entry.
  /// A name consists of at most 64 letters, digits, `_` and `-`.
  template <class Config, class Make>
  void named_sections(std::string_view key, std::vector<std::pair<std::string, Config>>& entries,
                      const Make& make, std::string_view doc, std::string_view entry_doc);
  template <class Config>
  void named_sections(std::string_view key, std::vector<std::pair<std::string, Config>>& entries,
                      std::string_view doc, std::string_view entry_doc) {
    named_sections(
        key, entries, [](const std::string&) { return Config{}; }, doc, entry_doc);
  }
  /// The keys of the section that is visited, for sections whose keys the user names; by default `current`.
  virtual std::vector<std::string> section_keys(std::vector<std::string> current) { return current; }
  /// Whether a section that may be absent is visited. `present`: the configuration has it now.
  virtual bool has_section(std::string_view, bool present) { return present; }

  // Keys that depend on others.
  /// Keys that exist only where `holds`. `condition` says when in words of the keys: "kind: lifetime".
  virtual void when(bool holds, std::string_view condition, const std::function<void()>& describe_keys);
  /// Whether values that nobody gave are to be filled in: true for a reader. A default that follows another key is set
  /// here, before its own key is visited: `if (v.fills_defaults()) b.size = a.size;`.
  [[nodiscard]] virtual bool fills_defaults() const { return false; }
  /// The path of a file that a key names, from where the program runs; none where the key is absent. Only a reader
  /// returns one: what the file holds takes the place of the key.
  virtual std::optional<std::string> file(std::string_view, std::string_view) { return std::nullopt; }
  /// The folder that a path in `key` is relative to; none where the key is absent. Only a reader returns one.
  virtual std::optional<std::string> folder_of(std::string_view) { return std::nullopt; }
  /// Files that `key` names in another way than path(), such as a program and its arguments. They may name further files
  /// relative to `folder`. Only a visitor that lists files calls `files`.
  virtual void reads(std::string_view /*key*/, const std::string& /*folder*/,
                     const std::function<std::vector<std::string>()>& /*files*/) {}
  /// A number that stands for other keys, such as a field of view for a focal length; none where the key is absent. Only a
  /// reader returns one.
  virtual std::optional<double> alternative(std::string_view, Range, std::string_view) {
    return std::nullopt;
  }
  /// A condition over several keys. `key` is the one that a message names, `found` its value.
  virtual void require(bool holds, std::string_view key, std::string_view found,
                       std::string_view expectation) = 0;
};

/// Whether a text may name an entry of a configuration: 1 to 64 letters, digits, `_` and `-`.
[[nodiscard]] bool is_name(std::string_view text);
inline constexpr std::string_view name_expectation = "a name of at most 64 letters, digits, _ and -";

/// Checks a config struct against its describe(); constructors use it. Throws InputError whose places are `name.key`.
class FieldChecker final : public FieldVisitor {
 public:
  explicit FieldChecker(std::string name) : name_(std::move(name)) {}

  void real(std::string_view key, double& value, Range range, std::string_view doc) override;
  void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) override;
  void boolean(std::string_view, bool&, std::string_view) override {}
  void text(std::string_view, std::string&, std::string_view) override {}
  void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
              std::string_view doc) override;
  void numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) override;
  void point_list(std::string_view key, std::vector<double>& values, std::size_t dimension, Range range,
                  std::string_view doc) override;
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

/// `config`. Throws InputError where it violates what describe(FieldVisitor&, Config&) states.
template <class Config>
const Config& check_config(std::string_view name, const Config& config) {
  FieldChecker checker{std::string(name)};
  Config copy = config;
  describe(checker, copy);
  checker.throw_if_any();
  return config;
}

/// Expectations in messages: "a number in [0, 1]", "one of a, b, c".
[[nodiscard]] std::string expectation_of(Range range, std::string_view kind);
[[nodiscard]] std::string expectation_of(const std::vector<std::string>& options);
/// The shortest decimal text that reads back as the same double.
[[nodiscard]] std::string text_of(double value);

template <class Enum>
requires std::is_enum_v<Enum>
void FieldVisitor::choice(std::string_view key, Enum& value, std::string_view doc) {
  const auto words = words_of(value);
  std::vector<std::string> options;
  options.reserve(words.size());
  for (const auto& known : words) options.emplace_back(known.word);
  std::string word(word_of(value));
  choice(key, word, options, doc);
  for (const auto& known : words) {
    if (known.word == word) value = known.value;
  }
}

template <class Point>
void FieldVisitor::points(std::string_view key, std::vector<Point>& points, Range range,
                          std::string_view doc) {
  constexpr std::size_t dimension = sizeof(Point) / sizeof(double);
  std::vector<double> values;
  for (const Point& point : points) values.insert(values.end(), point.data(), point.data() + dimension);
  point_list(key, values, dimension, range, doc);
  points.resize(values.size() / dimension);
  for (std::size_t i = 0; i < values.size(); ++i) points[i / dimension][i % dimension] = values[i];
}

template <class Config>
void FieldVisitor::optional_section(std::string_view key, std::optional<Config>& config,
                                    std::string_view doc) {
  if (!has_section(key, config.has_value())) return;
  if (!config) config.emplace();
  section(key, *config, doc);
}

template <class Config, class Make>
void FieldVisitor::named_sections(std::string_view key, std::vector<std::pair<std::string, Config>>& entries,
                                  const Make& make, std::string_view doc, std::string_view entry_doc) {
  section(
      key,
      [&](FieldVisitor& v) {
        std::vector<std::string> names;
        for (const auto& entry : entries) names.push_back(entry.first);
        for (const std::string& name : v.section_keys(names)) {
          bool known = false;
          for (const auto& entry : entries) known = known || entry.first == name;
          if (!known) entries.emplace_back(name, make(name));
        }
        for (auto& [name, config] : entries) {
          v.section(name, config, entry_doc);
          v.require(is_name(name), name, "such a name", name_expectation);
        }
      },
      doc);
}

}  // namespace saccade
