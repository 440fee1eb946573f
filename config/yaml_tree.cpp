#include "config/yaml_tree.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

namespace saccade {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 20;
constexpr std::string_view root_expectation = "a block of keys, as in \"name: value\"";

std::string joined(std::string_view path, std::string_view key) {
  return path.empty() ? std::string(key) : std::string(path) + "." + std::string(key);
}

/// Length of the UTF-8 sequence at the front of `bytes`; 0 when it is not one (RFC 3629).
std::size_t utf8_length(std::string_view bytes) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xc2 && first < 0xe0   ? 2
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  if (length == 0 || bytes.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool overlong = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
  const bool surrogate = first == 0xed && byte(1) >= 0xa0;
  const bool too_high = first == 0xf4 && byte(1) >= 0x90;
  return overlong || surrogate || too_high ? 0 : length;
}

std::string hex_of(unsigned char byte) {
  constexpr std::string_view digits = "0123456789abcdef";
  return {'0', 'x', digits[byte >> 4], digits[byte & 15]};
}

/// Builds the tree of the first document out of the parser's events.
class TreeBuilder final : public YAML::EventHandler {
 public:
  /// `from_set`: marks say so, and paths start with `path`.
  TreeBuilder(YamlTree& tree, bool from_set, std::string path)
      : tree_(tree), from_set_(from_set), base_path_(std::move(path)) {}

  [[nodiscard]] YamlNode take_root() { return std::move(root_); }

  /// Line and column of the parser's mark; its null mark becomes line 1.
  [[nodiscard]] TextMark mark_of(const YAML::Mark& mark) const {
    if (from_set_) return {};
    return {std::max(mark.line, 0) + 1, std::max(mark.column, 0) + 1};
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ == 1) complain(mark_of(mark), "", "a second document", "one document in a file");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    check_decoration(mark, "", anchor);
    add(node_at(YamlNode::Kind::nothing, mark));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    complain(mark_of(mark), path(), "an alias (*)", "the value itself");
    add(node_at(YamlNode::Kind::rejected, mark));
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    // yaml-cpp marks a plain scalar by the tag "?" and one in quotes by "!".
    const bool quoted = tag == "!";
    const bool tagged = check_decoration(mark, quoted ? "" : tag, anchor);
    YamlNode node = node_at(tagged ? YamlNode::Kind::rejected : YamlNode::Kind::scalar, mark);
    node.text = value;
    node.quoted = quoted;
    add(std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::list, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::map, mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Key {
    std::string text;
    TextMark mark;
    bool usable = true;
  };
  struct Open {
    YamlNode node;
    std::optional<Key> key;  // of a map: the one whose value comes next
  };

  [[nodiscard]] YamlNode node_at(YamlNode::Kind kind, const YAML::Mark& mark) const {
    return YamlNode::of(kind, mark_of(mark));
  }

  [[nodiscard]] std::string path() const {
    std::string path = base_path_;
    for (const Open& open : open_) {
      if (open.node.kind == YamlNode::Kind::list) path += "[" + std::to_string(open.node.items.size()) + "]";
      if (open.key) path = joined(path, open.key->text);
    }
    return path;
  }

  void complain(TextMark mark, std::string_view path, std::string value, std::string expectation) {
    tree_.problems.push_back({mark, {tree_.place(mark, path), std::move(value), std::move(expectation)}});
  }

  /// Reports anchors and tags as problems; true when there is a tag.
  bool check_decoration(const YAML::Mark& mark, std::string_view tag, YAML::anchor_t anchor) {
    const bool tagged = !tag.empty() && tag != "?";
    if (anchor != YAML::NullAnchor) complain(mark_of(mark), path(), "an anchor (&)", "the value alone");
    if (tagged) complain(mark_of(mark), path(), "the tag " + std::string(tag), "the value alone");
    return tagged;
  }

  void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    check_decoration(mark, tag, anchor);
    open_.push_back({node_at(kind, mark), std::nullopt});
  }
  void close() {
    YamlNode node = std::move(open_.back().node);
    open_.pop_back();
    add(std::move(node));
  }

  void add(YamlNode node) {
    if (documents_ > 1) return;
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    if (parent.node.kind == YamlNode::Kind::list) {
      parent.node.items.push_back(std::move(node));
    } else if (!parent.key) {
      const bool usable = node.kind == YamlNode::Kind::scalar;
      if (!usable && node.kind != YamlNode::Kind::rejected) {
        complain(node.mark, path(), node.found() + " as a key", "a word as a key");
      }
      parent.key = Key{node.text, node.mark, usable};
    } else {
      add_entry(parent, std::move(node));
    }
  }
  void add_entry(Open& parent, YamlNode value) {
    const std::string path_of_key = path();
    const Key key = *std::exchange(parent.key, std::nullopt);
    if (!key.usable) return;
    if (const YamlNode* first = parent.node.entry(key.text)) {
      const int line = first->mark.line;
      complain(key.mark, path_of_key, "the key a second time",
               "each key once" + (line > 0 ? " (first on line " + std::to_string(line) + ")" : ""));
      return;
    }
    value.mark = key.mark;
    parent.node.keys.push_back(key.text);
    parent.node.items.push_back(std::move(value));
  }

  YamlTree& tree_;
  bool from_set_;
  std::string base_path_;
  int documents_ = 0;
  YamlNode root_;
  std::vector<Open> open_;
};

/// Reports what yaml-cpp accepts without an error: control characters (it ends a file at byte 4), bytes that are not
/// UTF-8, directives, tabs. Throws for the first two, which leave nothing worth reading.
void check_bytes(YamlTree& tree, std::string_view text, bool from_set, std::string_view path) {
  TextMark mark{from_set ? 0 : 1, 0};
  const auto place = [&] { return tree.place(mark, path); };
  const auto next_line = [&] { mark = from_set ? TextMark{} : TextMark{mark.line + 1, 0}; };
  int line_with_tab = -1;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t length = utf8_length(text.substr(i));
    mark.column += from_set ? 0 : 1;
    if (length == 0) throw InputError(place(), "byte " + hex_of(byte), "text in UTF-8");
    if (byte == '\t' && line_with_tab != mark.line) {
      line_with_tab = mark.line;
      tree.problems.push_back({mark, {place(), "a tab", "spaces"}});
    }
    if (byte == '%' && (i == 0 || text[i - 1] == '\n')) {
      tree.problems.push_back({mark, {place(), "a directive (%)", "a file without directives"}});
    }
    const bool line_break = byte == '\n' || (byte == '\r' && text.substr(i + 1).starts_with('\n'));
    if ((byte < 0x20 && byte != '\t' && !line_break) || byte == 0x7f) {
      throw InputError(place(), "byte " + hex_of(byte), "text without control characters");
    }
    if (byte == '\n') next_line();
    i += length;
  }
}

/// Parses one document of any kind; throws InputError with all problems so far where it cannot.
YamlNode parse_document(YamlTree& tree, std::string_view text, bool from_set, const std::string& path) {
  check_bytes(tree, text, from_set, path);
  TreeBuilder builder(tree, from_set, path);
  std::istringstream stream{std::string(text)};
  try {
    YAML::Parser parser(stream);
    // At most two are parsed: after some broken input the parser returns empty documents without end.
    if (parser.HandleNextDocument(builder)) parser.HandleNextDocument(builder);
  } catch (const YAML::Exception& error) {
    const TextMark mark = builder.mark_of(error.mark);
    const std::string column = from_set ? "" : "column " + std::to_string(mark.column);
    tree.problems.push_back(
        {mark, {tree.place(mark, from_set ? path : column), error.msg, "YAML that can be parsed"}});
    throw_if_any(tree.problems);
  }
  return builder.take_root();
}

std::vector<std::string> split_path(std::string_view path) {
  std::vector<std::string> keys;
  for (std::size_t start = 0; start <= path.size();) {
    const std::size_t end = std::min(path.find('.', start), path.size());
    keys.emplace_back(path.substr(start, end - start));
    start = end + 1;
  }
  return keys;
}

/// Puts `value` at `path`, with the maps on the way to it.
void place_value(YamlNode& root, const std::vector<std::string>& keys, const std::string& path,
                 YamlNode value, std::vector<MarkedProblem>& problems) {
  YamlNode* node = &root;
  std::string walked;
  for (const std::string& key : keys) {
    if (node->kind != YamlNode::Kind::map) break;
    const auto at = std::find(node->keys.begin(), node->keys.end(), key) - node->keys.begin();
    if (at == std::ssize(node->keys)) {
      node->keys.push_back(key);
      node->items.push_back(YamlNode::of(YamlNode::Kind::map));
    }
    node = &node->items[static_cast<std::size_t>(at)];
    walked = joined(walked, key);
  }
  if (walked == path) {
    *node = std::move(value);
  } else {
    problems.push_back({{}, {"--set " + path, node->found() + " at " + walked, "a block of keys there"}});
  }
}

void forget_marks(YamlNode& node) {
  node.mark = {};
  for (YamlNode& item : node.items) forget_marks(item);
}

}  // namespace

YamlNode YamlNode::of(Kind kind, TextMark mark) {
  YamlNode node;
  node.kind = kind;
  node.mark = mark;
  return node;
}

const YamlNode* YamlNode::entry(std::string_view key) const {
  const auto it = std::find(keys.begin(), keys.end(), key);
  return it == keys.end() ? nullptr : &items[static_cast<std::size_t>(it - keys.begin())];
}

const YamlNode* YamlNode::find(std::string_view path) const {
  const YamlNode* node = this;
  for (const std::string& key : split_path(path)) {
    if (node != nullptr) node = node->entry(key);
  }
  return node;
}

std::string YamlNode::found() const {
  switch (kind) {
    case Kind::list:
      return "a list";
    case Kind::map:
      return "a block of keys";
    case Kind::scalar:
      break;
    default:
      return "nothing";
  }
  const bool one_line = std::none_of(text.begin(), text.end(), [](char c) { return c >= 0 && c < ' '; });
  std::string shown = quoted || !one_line ? quote_yaml(text) : text;
  constexpr std::size_t longest = 80;
  if (shown.size() > longest) {
    std::size_t end = longest;
    while ((static_cast<unsigned char>(shown[end]) & 0xc0) == 0x80) --end;  // not inside a character
    shown = shown.substr(0, end) + "...";
  }
  return shown;
}

std::string YamlNode::one_line() const {
  std::string line;
  switch (kind) {
    case Kind::scalar:
      return quoted ? quote_yaml(text) : text;
    case Kind::list:
      for (const YamlNode& item : items) line += (line.empty() ? "" : ", ") + item.one_line();
      return "[" + line + "]";
    case Kind::map:
      for (std::size_t i = 0; i < keys.size(); ++i) {
        line += (i == 0 ? "" : ", ") + keys[i] + ": " + items[i].one_line();
      }
      return "{" + line + "}";
    default:
      return "null";
  }
}

std::string YamlTree::place(TextMark mark, std::string_view path) const {
  if (mark.line == 0) return "--set " + std::string(path);
  const std::string line = file + ":" + std::to_string(mark.line);
  return path.empty() ? line : line + ": " + std::string(path);
}

YamlTree read_yaml_file(const std::filesystem::path& path) {
  return parse_yaml(read_yaml_text(path), path.string());
}

std::string read_yaml_text(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw InputError(name, "a folder", "a YAML file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    const bool exists = std::filesystem::exists(path, error);
    throw InputError(name, exists ? "a file that cannot be opened" : "no such file", "a readable YAML file");
  }
  std::string text(max_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) throw InputError(name, "a file that cannot be read", "a readable YAML file");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

YamlTree parse_yaml(std::string_view text, std::string file) {
  if (text.size() > max_bytes) throw InputError(file, "more than 1 MiB", "a YAML file of at most 1 MiB");
  YamlTree tree;
  tree.file = std::move(file);
  tree.root = parse_document(tree, text, false, "");
  if (tree.root.kind != YamlNode::Kind::map) {
    const TextMark mark{std::max(tree.root.mark.line, 1), tree.root.mark.column};
    const std::string found = tree.root.found();
    tree.problems.push_back({mark, {tree.place(mark, ""), found, std::string(root_expectation)}});
    throw_if_any(tree.problems);
  }
  return tree;
}

std::optional<YamlTree> block_of(const YamlTree& tree, std::string_view key) {
  const YamlNode* const node = tree.root.entry(key);
  if (node == nullptr) return std::nullopt;
  YamlTree block;
  block.file = tree.file;
  block.root.keys = {std::string(key)};
  block.root.items = {*node};
  return block;
}

void set_value(YamlTree& tree, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string path(assignment.substr(0, equals));
  const std::vector<std::string> keys = split_path(path);
  if (equals == std::string_view::npos || std::find(keys.begin(), keys.end(), "") != keys.end()) {
    tree.problems.push_back({{}, {"--set", quote_yaml(assignment), "key.path=value"}});
    return;
  }
  YamlTree parsed;
  const std::string_view text = assignment.substr(equals + 1);
  try {
    YamlNode value = parse_document(parsed, text, true, path);
    const bool is_null = value.kind == YamlNode::Kind::nothing &&
                         text.find_first_not_of(' ') != std::string_view::npos && parsed.problems.empty();
    if (is_null) {
      remove_node(tree, path);
    } else {
      place_value(tree.root, keys, path, std::move(value), parsed.problems);
    }
  } catch (const InputError& error) {
    parsed.problems.clear();
    for (const Problem& problem : error.problems()) parsed.problems.push_back({{}, problem});
  }
  tree.problems.insert(tree.problems.end(), parsed.problems.begin(), parsed.problems.end());
}

void set_node(YamlTree& tree, std::string_view path, YamlNode value) {
  forget_marks(value);
  place_value(tree.root, split_path(path), std::string(path), std::move(value), tree.problems);
}

void remove_node(YamlTree& tree, std::string_view path) {
  const std::vector<std::string> keys = split_path(path);
  YamlNode* node = &tree.root;
  for (const std::string& key : keys) {
    const auto at = std::find(node->keys.begin(), node->keys.end(), key) - node->keys.begin();
    if (at == std::ssize(node->keys)) {
      tree.not_there.emplace_back(path);
      return;
    }
    if (&key == &keys.back()) {
      node->keys.erase(node->keys.begin() + at);
      node->items.erase(node->items.begin() + at);
      return;
    }
    node = &node->items[static_cast<std::size_t>(at)];
  }
}

void throw_if_any(std::vector<MarkedProblem> problems) {
  if (problems.empty()) return;
  const auto order = [](const MarkedProblem& p) {
    return p.mark.line == 0 ? TextMark{std::numeric_limits<int>::max(), 0} : p.mark;
  };
  std::stable_sort(problems.begin(), problems.end(),
                   [&](const MarkedProblem& a, const MarkedProblem& b) { return order(a) < order(b); });
  std::vector<Problem> sorted;
  sorted.reserve(problems.size());
  for (MarkedProblem& problem : problems) sorted.push_back(std::move(problem.problem));
  throw InputError(std::move(sorted));
}

std::string quote_yaml(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (c == '\t') {
      quoted += "\\t";
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += "\\x" + hex_of(byte).substr(2);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

}  // namespace saccade
