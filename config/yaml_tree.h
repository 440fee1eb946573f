#pragma once

#include <compare>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace saccade {

/// Line and column in a file, from 1. Line 0: not from a file but from a `--set`.
struct TextMark {
  int line = 0;
  int column = 0;

  friend auto operator<=>(const TextMark&, const TextMark&) = default;
};

/// A node of YAML as it was written. Scalars are text; YamlReader converts them.
struct YamlNode {
  enum class Kind {
    nothing,  ///< no value, or null
    scalar,
    list,
    map,
    rejected,  ///< a problem of its own stands in YamlTree::problems; not to be complained about twice
  };

  Kind kind = Kind::nothing;
  TextMark mark;        ///< of its key where it has one
  std::string text;     ///< of a scalar, without the quotes
  bool quoted = false;  ///< a scalar in quotes or a text block: text, even where it looks like a number
  std::vector<YamlNode> items;    ///< of a list, or the values of a map
  std::vector<std::string> keys;  ///< of a map: keys[i] belongs to items[i]; each once, in file order

  [[nodiscard]] static YamlNode of(Kind kind, TextMark mark = {});
  /// The value of a key of this map; nullptr when there is none.
  [[nodiscard]] const YamlNode* entry(std::string_view key) const;
  /// The value at "ball.trajectory.speed_m_s"; nullptr when there is none.
  [[nodiscard]] const YamlNode* find(std::string_view path) const;
  /// For messages: the scalar as written, or "a list", "a block of keys", "nothing".
  [[nodiscard]] std::string found() const;
  /// The value on one line, as YAML that reads back the same: 0.5, [1, 2], {a: 1, b: "2"}.
  [[nodiscard]] std::string one_line() const;
};

/// A problem and its position, for sorting.
struct MarkedProblem {
  TextMark mark;
  Problem problem;
};

/// A configuration file, its root a map. Problems that leave the rest readable (a key given twice, an
/// anchor, a tab ...) are collected here, for a YamlReader to report together with its own.
struct YamlTree {
  std::string file;  ///< as the user named it; empty when there is none and all comes from `--set`
  YamlNode root = YamlNode::of(YamlNode::Kind::map);
  std::vector<MarkedProblem> problems;
  std::vector<std::string> not_there;  ///< paths that null was to remove and that are not in the tree

  /// "file:12: key.path", "--set key.path" for line 0.
  [[nodiscard]] std::string place(TextMark mark, std::string_view path) const;
};

/// Reads a file of UTF-8 text, at most 1 MiB. Throws InputError where no tree can be built: missing
/// or unreadable file, nothing in it, binary bytes, broken syntax, a root that is not a map.
[[nodiscard]] YamlTree read_yaml_file(const std::filesystem::path& path);
/// The same of a text; `file` is its name in messages.
[[nodiscard]] YamlTree parse_yaml(std::string_view text, std::string file);
/// The text of a file for parse_yaml(); of a longer one its first 1 MiB and a byte. Throws InputError.
[[nodiscard]] std::string read_yaml_text(const std::filesystem::path& path);

/// The tree with one key of its root alone; none without that key.
[[nodiscard]] std::optional<YamlTree> block_of(const YamlTree& tree, std::string_view key);

/// Applies `key.path=value` to the tree: replaces the value there, or adds it with the maps on the way to it.
/// The value is YAML: a number, true, a [list], a {map: 1}, text; null removes the key. The last of several for one path
/// wins. What is wrong with it is added to tree.problems.
void set_value(YamlTree& tree, std::string_view assignment);

/// The same with a node, such as one from another file; messages name it as a `--set`.
void set_node(YamlTree& tree, std::string_view path, YamlNode value);

/// Removes a key and everything below it; one that is absent is noted in tree.not_there.
void remove_node(YamlTree& tree, std::string_view path);

/// Throws InputError with the problems in file order, those of `--set` last, when there are any.
void throw_if_any(std::vector<MarkedProblem> problems);

/// The text in double quotes with YAML's escapes, on one line.
[[nodiscard]] std::string quote_yaml(std::string_view text);

}  // namespace saccade
