#pragma once

#include <compare>
#include <filesystem>
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

/// A piece of YAML as it was written; what a scalar means is the reader's business.
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

/// Where a problem is, for sorting, and what it is.
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

  /// "file:12: key.path", "--set key.path" for line 0.
  [[nodiscard]] std::string place(TextMark mark, std::string_view path) const;
};

/// Reads a file of UTF-8 text, at most 1 MiB. Throws InputError where there is no tree to speak of: missing
/// or unreadable file, nothing in it, binary bytes, broken syntax, a root that is not a map.
[[nodiscard]] YamlTree read_yaml_file(const std::filesystem::path& path);
/// The same of a text; `file` is its name in messages.
[[nodiscard]] YamlTree parse_yaml(std::string_view text, std::string file);

/// Lays `key.path=value` over the tree: replaces the value there, or adds it with the maps on the way to it.
/// The value is YAML: a number, true, a [list], a {map: 1}, text. The last of several for one path wins. What
/// is wrong with it is added to tree.problems.
void set_value(YamlTree& tree, std::string_view assignment);

/// The same with a value that is there already, such as one from another file; messages speak of it as of `--set`.
void set_node(YamlTree& tree, std::string_view path, YamlNode value);

/// Takes a key and what is below it out of the tree, where it is there.
void remove_node(YamlTree& tree, std::string_view path);

/// Throws InputError with the problems in file order, those of `--set` last, when there are any.
void throw_if_any(std::vector<MarkedProblem> problems);

/// The text in double quotes with YAML's escapes, on one line.
[[nodiscard]] std::string quote_yaml(std::string_view text);

}  // namespace saccade
