#include "config/migrate.h"

#include <algorithm>

#include "config/yaml_tree.h"
#include "core/error.h"

namespace saccade {
namespace {

using Kind = YamlNode::Kind;
using Words = std::vector<std::string>;

Words words_of_path(std::string_view path) {
  Words words;
  for (std::size_t start = 0; start <= path.size();) {
    const std::size_t end = std::min(path.find('.', start), path.size());
    words.emplace_back(path.substr(start, end - start));
    start = end + 1;
  }
  return words;
}

std::string path_of(const Words& words) {
  std::string path;
  for (const std::string& word : words) path += (path.empty() ? "" : ".") + word;
  return path;
}

bool matches(const Words& path, const Words& pattern) {
  return path.size() == pattern.size() &&
         std::equal(path.begin(), path.end(), pattern.begin(),
                    [](const std::string& word, const std::string& p) { return p == "*" || p == word; });
}

/// The words of an old path, each in the current spelling.
Words today(const Words& old) {
  Words renamed = old;
  for (std::size_t i = 0; i < old.size(); ++i) {
    if (const auto key = new_key_of(path_of({old.begin(), old.begin() + static_cast<std::ptrdiff_t>(i) + 1})))
      renamed[i] = *key;
  }
  return renamed;
}

/// A piece of the text that a rename replaces.
struct Replacement {
  TextMark mark;
  std::string old_text;
  std::string new_text;
};

/// Walks over a file and collects the keys to replace.
class Walk {
 public:
  explicit Walk(const YamlTree& tree) : tree_(tree) {
    const YamlNode& root = tree.root;
    if (root.entry("axes") == nullptr) {
      block(root, {});
      return;
    }
    for (const char* key : {"set", "axes"}) {
      if (const YamlNode* settings = root.entry(key)) paths(*settings);
    }
    for (const char* key : {"except", "only"}) {
      const YamlNode* rules = root.entry(key);
      if (rules == nullptr || rules->kind != Kind::list) continue;
      for (const YamlNode& rule : rules->items) paths(rule);
    }
  }

  [[nodiscard]] std::vector<Replacement> take() && { return std::move(replacements_); }

 private:
  /// A block of keys whose path in the old spelling is `path`.
  void block(const YamlNode& node, const Words& path) {
    if (node.kind != Kind::map) return;
    for (std::size_t i = 0; i < node.keys.size(); ++i) {
      Words inner = path;
      inner.push_back(node.keys[i]);
      rename(node, i, today(inner).back());
      block(node.items[i], inner);
    }
  }

  /// A block of a sweep whose keys are paths such as things.cup.size_m, or names of axes with `cases`.
  void paths(const YamlNode& node) {
    if (node.kind != Kind::map) return;
    for (std::size_t i = 0; i < node.keys.size(); ++i) {
      if (const YamlNode* cases = node.items[i].entry("cases");
          cases != nullptr && cases->kind == Kind::map) {
        for (const YamlNode& values : cases->items) paths(values);
        continue;
      }
      const Words words = words_of_path(node.keys[i]);
      rename(node, i, path_of(today(words)));
      if (node.items[i].kind == Kind::map) block(node.items[i], words);
    }
  }

  void rename(const YamlNode& node, std::size_t i, const std::string& renamed) {
    if (renamed == node.keys[i]) return;
    const TextMark mark = node.items[i].mark;
    if (node.entry(renamed) != nullptr) {
      throw InputError(tree_.place(mark, node.keys[i]), "the old key beside its new one, " + renamed,
                       "one of them");
    }
    replacements_.push_back({mark, node.keys[i], renamed});
  }

  const YamlTree& tree_;
  std::vector<Replacement> replacements_;
};

/// Where the lines of a text begin.
std::vector<std::size_t> line_starts(const std::string& text) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  std::vector<std::size_t> starts = {text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0};
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') starts.push_back(i + 1);
  }
  return starts;
}

bool same(const YamlNode& a, const YamlNode& b) {
  return a.kind == b.kind && a.text == b.text && a.quoted == b.quoted && a.items.size() == b.items.size() &&
         std::equal(a.items.begin(), a.items.end(), b.items.begin(), same);
}

}  // namespace

const std::vector<RenamedKey>& renamed_keys() {
  static const std::vector<RenamedKey> keys = {{"things", "objects"}};
  return keys;
}

std::optional<std::string> new_key_of(std::string_view path) {
  const Words words = words_of_path(path);
  for (const RenamedKey& renamed : renamed_keys()) {
    if (matches(words, words_of_path(renamed.old_path))) return std::string(renamed.new_key);
  }
  return std::nullopt;
}

Migration migrate(const std::string& text, const std::string& file) {
  const YamlTree tree = parse_yaml(text, file);
  throw_if_any(tree.problems);
  std::vector<Replacement> replacements = Walk(tree).take();
  std::sort(replacements.begin(), replacements.end(),
            [](const Replacement& a, const Replacement& b) { return a.mark < b.mark; });
  const std::vector<std::size_t> starts = line_starts(text);
  Migration result{text, {}};
  for (auto it = replacements.rbegin(); it != replacements.rend(); ++it) {
    const auto line = static_cast<std::size_t>(it->mark.line - 1);
    const std::size_t begin = line < starts.size() ? starts[line] : text.size();
    std::size_t at = begin + static_cast<std::size_t>(it->mark.column - 1);
    if (at < text.size() && (text[at] == '"' || text[at] == '\'')) ++at;
    if (text.compare(std::min(at, text.size()), it->old_text.size(), it->old_text) != 0) {
      throw InputError(tree.place(it->mark, it->old_text), "a key in another spelling",
                       "this key as plain text, to be replaced by " + it->new_text);
    }
    result.text.replace(at, it->old_text.size(), it->new_text);
    result.renames.insert(result.renames.begin(), {it->mark.line, it->old_text, it->new_text});
  }
  // The values are unchanged, and no key is left to rename.
  const YamlTree migrated = parse_yaml(result.text, file);
  SACCADE_CHECK(same(tree.root, migrated.root) && Walk(migrated).take().empty());
  return result;
}

}  // namespace saccade
