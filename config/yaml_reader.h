#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/source_keys.h"
#include "config/yaml_tree.h"
#include "core/config.h"

namespace saccade {

/// Reads a tree into config structs through their `describe`. A missing key leaves the default; a key that
/// no describe() names is a problem, and so is every value that its key does not take:
///   numbers    decimal, finite, in range, no leading zero, not in quotes; whole ones are digits alone
///   booleans   true or false
///   text       in quotes where it would read as a number, a boolean or null
/// A field with a problem keeps its default. `require` is not evaluated in a block with a rejected value, because it
/// would check the default instead.
///
///     YamlReader reader(tree, {"name", "ball.trajectory"});
///     describe(reader, scenario);
///     reader.finish();
class YamlReader final : public FieldVisitor, public SourceKeys {
 public:
  /// `tree` must outlive the reader. `required`: paths of keys that have no default. Files that the tree names are
  /// relative to `folder`, those of --set to the working directory.
  explicit YamlReader(const YamlTree& tree, std::vector<std::string> required = {}, std::string folder = {});

  void real(std::string_view key, double& value, Range range, std::string_view doc) override;
  void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) override;
  void boolean(std::string_view key, bool& value, std::string_view doc) override;
  void text(std::string_view key, std::string& value, std::string_view doc) override;
  void path(std::string_view key, std::string& value, std::string_view doc) override;
  void model(std::string_view key, ModelFile& file, std::string_view doc) override;
  void program(std::string_view key, std::string& value, std::string_view doc) override;
  void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
              std::string_view doc) override;
  void numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) override;
  void point_list(std::string_view key, std::vector<double>& values, std::size_t dimension, Range range,
                  std::string_view doc) override;
  std::vector<std::string> section_keys(std::vector<std::string> current) override;
  bool has_section(std::string_view key, bool present) override;
  [[nodiscard]] bool fills_defaults() const override { return true; }
  std::optional<std::string> file(std::string_view key, std::string_view doc) override;
  std::optional<std::vector<std::string>> names(std::string_view key, std::string_view doc) override;
  std::optional<std::string> word(std::string_view key, std::string_view usual,
                                  std::string_view doc) override;
  std::optional<std::string> folder_of(std::string_view key) override;
  std::optional<double> alternative(std::string_view key, Range range, std::string_view doc) override;
  void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
               std::string_view doc) override;
  void require(bool holds, std::string_view key, std::string_view found,
               std::string_view expectation) override;

  /// Throws InputError with every problem of the tree and of the reading, in file order. Call it once, last.
  void finish();

 private:
  /// The block of keys that is being read.
  struct Block {
    const YamlNode* node = nullptr;  // nullptr: not in the file
    TextMark mark;                   // where to point for a missing key
    std::string path;
    std::vector<std::string> known;
    std::size_t problems_before = 0;
  };

  const YamlNode* take(std::string_view key, const std::string& expectation);
  [[nodiscard]] std::string path_of(std::string_view key) const;
  void refuse(const YamlNode& node, std::string_view path, std::string expectation,
              std::string_view note = {});
  std::optional<double> number(const YamlNode& node, std::string_view path, Range range);
  std::optional<std::vector<double>> list(const YamlNode& node, std::string_view path, std::size_t size,
                                          Range range);
  void report_unknown();
  void report_if_unknown(const std::string& key, TextMark mark);

  const YamlTree& tree_;
  std::string folder_;
  std::vector<std::string> required_;
  Block block_;
  std::vector<MarkedProblem> problems_;
};

/// Reads the whole tree into `config`, whose values are the defaults. Throws InputError with all problems.
template <class Config>
[[nodiscard]] Config read_config(const YamlTree& tree, Config config = {},
                                 std::vector<std::string> required = {}) {
  YamlReader reader(tree, std::move(required));
  describe(reader, config);
  reader.finish();
  return config;
}

}  // namespace saccade
