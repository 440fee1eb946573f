#include "config/yaml_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <memory>

#include "config/migrate.h"
#include "core/error.h"
#include "core/model_arrays.h"
#include "core/nearest_name.h"
#include "recording/model_file.h"

namespace saccade {
namespace {

using Kind = YamlNode::Kind;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

/// A sign, digits, a fraction, an exponent; the decimal numbers that every YAML reader reads the same.
bool is_decimal(std::string_view text, bool whole) {
  std::size_t i = 0;
  const auto digits = [&] {
    const std::size_t start = i;
    while (i < text.size() && is_digit(text[i])) ++i;
    return i - start;
  };
  const auto at = [&](std::string_view options) {
    return i < text.size() && options.find(text[i]) != std::string_view::npos;
  };
  if (at("+-")) ++i;
  const bool zero = at("0");
  const std::size_t before = digits();
  if (zero && before > 1) return false;
  std::size_t after = 0;
  if (!whole && at(".")) {
    ++i;
    after = digits();
  }
  if (before + after == 0) return false;
  if (!whole && at("eE")) {
    ++i;
    if (at("+-")) ++i;
    if (digits() == 0) return false;
  }
  return i == text.size();
}

/// The reason why text that looks like a number is none; empty for other text.
std::string_view number_note(const YamlNode& node) {
  if (node.kind != Kind::scalar) return {};
  if (node.quoted) return is_decimal(node.text, false) ? " (in quotes, so it is text)" : "";
  std::string text = lower(node.text);
  if (text.starts_with('-') || text.starts_with('+')) text.erase(0, 1);
  if (text == ".nan" || text == "nan" || text == ".inf" || text == "inf") return " (not finite)";
  if (text.size() < 2 || text[0] != '0') return {};
  if (text[1] == 'x' || text[1] == 'o' || text[1] == 'b') return " (not decimal)";
  return is_digit(text[1]) ? " (leading zero)" : "";
}

/// Plain scalars that a YAML reader may read as a number, a boolean or null.
bool reads_as_other_than_text(const YamlNode& node) {
  constexpr std::array<std::string_view, 4> words = {"true", "false", "null", "~"};
  const std::string text = lower(node.text);
  return is_decimal(node.text, false) || !number_note(node).empty() ||
         std::find(words.begin(), words.end(), text) != words.end();
}

template <class Number>
std::optional<Number> converted(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string one_or_list(std::size_t size, const std::string& of, Range range) {
  return expectation_of(range, (size == 0 ? "a list of " : "a list of " + std::to_string(size) + " ") + of);
}

}  // namespace

YamlReader::YamlReader(const YamlTree& tree, std::vector<std::string> required, std::string folder)
    : tree_(tree), folder_(std::move(folder)), required_(std::move(required)), problems_(tree.problems) {
  block_ = {&tree.root, tree.root.mark, "", {}, problems_.size()};
}

std::string YamlReader::path_of(std::string_view key) const {
  return (block_.path.empty() ? "" : block_.path + ".") + std::string(key);
}

void YamlReader::refuse(const YamlNode& node, std::string_view path, std::string expectation,
                        std::string_view note) {
  if (node.kind == Kind::rejected) return;
  problems_.push_back(
      {node.mark, {tree_.place(node.mark, path), node.found() + std::string(note), std::move(expectation)}});
}

/// The value of a key; nullptr when it is absent, which is a problem where the key is required.
const YamlNode* YamlReader::take(std::string_view key, const std::string& expectation) {
  block_.known.emplace_back(key);
  const YamlNode* node = block_.node != nullptr ? block_.node->entry(key) : nullptr;
  const std::string path = path_of(key);
  if (node == nullptr && std::find(required_.begin(), required_.end(), path) != required_.end()) {
    const std::string place = block_.mark.line > 0 ? tree_.place(block_.mark, path) : path;
    problems_.push_back({block_.mark, {place, "no such key", expectation}});
  }
  return node;
}

std::optional<double> YamlReader::number(const YamlNode& node, std::string_view path, Range range) {
  const std::string expectation = expectation_of(range, "a finite number");
  if (node.kind != Kind::scalar || node.quoted || !is_decimal(node.text, false)) {
    refuse(node, path, expectation, number_note(node));
    return std::nullopt;
  }
  const auto value = converted<double>(node.text);
  if (!value || !range.contains(*value)) {
    refuse(node, path, expectation, value ? "" : " (beyond a double)");
    return std::nullopt;
  }
  return value;
}

std::optional<std::vector<double>> YamlReader::list(const YamlNode& node, std::string_view path,
                                                    std::size_t size, Range range) {
  if (node.kind != Kind::list) {
    refuse(node, path, one_or_list(size, "finite numbers", range));
    return std::nullopt;
  }
  const std::size_t problems_before = problems_.size();
  std::vector<double> values;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const std::string element = std::string(path) + "[" + std::to_string(i) + "]";
    values.push_back(number(node.items[i], element, range).value_or(0.0));
    if (node.items[i].kind == Kind::rejected) return std::nullopt;
  }
  if (size != 0 && node.items.size() != size) {
    refuse(node, path, one_or_list(size, "finite numbers", range),
           " of " + std::to_string(node.items.size()));
  }
  if (problems_.size() > problems_before) return std::nullopt;
  return values;
}

void YamlReader::real(std::string_view key, double& value, Range range, std::string_view) {
  const YamlNode* node = take(key, expectation_of(range, "a finite number"));
  if (node == nullptr) return;
  value = number(*node, path_of(key), range).value_or(value);
}

void YamlReader::integer(std::string_view key, std::int64_t& value, Range range, std::string_view) {
  const std::string expectation = expectation_of(range, "a whole number");
  const YamlNode* node = take(key, expectation);
  if (node == nullptr) return;
  std::optional<std::int64_t> whole;
  if (node->kind == Kind::scalar && !node->quoted && is_decimal(node->text, true)) {
    whole = converted<std::int64_t>(node->text);
  }
  if (whole && range.contains(static_cast<double>(*whole))) {
    value = *whole;
  } else {
    refuse(*node, path_of(key), expectation, number_note(*node));
  }
}

void YamlReader::boolean(std::string_view key, bool& value, std::string_view) {
  const YamlNode* node = take(key, "true or false");
  if (node == nullptr) return;
  const bool plain = node->kind == Kind::scalar && !node->quoted;
  if (plain && (node->text == "true" || node->text == "false")) {
    value = node->text == "true";
  } else {
    refuse(*node, path_of(key), "true or false");
  }
}

void YamlReader::text(std::string_view key, std::string& value, std::string_view) {
  const YamlNode* node = take(key, "text");
  if (node == nullptr) return;
  if (node->kind != Kind::scalar) {
    refuse(*node, path_of(key), "text");
  } else if (!node->quoted && reads_as_other_than_text(*node)) {
    refuse(*node, path_of(key), "text, in quotes if this is meant");
  } else {
    value = node->text;
  }
}

void YamlReader::path(std::string_view key, std::string& value, std::string_view doc) {
  text(key, value, doc);
  const std::optional<std::string> folder = folder_of(key);
  if (folder && !value.empty())  // empty: no file
    value = (std::filesystem::path(*folder) / value).lexically_normal().string();
}

void YamlReader::model(std::string_view key, ModelFile& file, std::string_view doc) {
  const std::size_t problems_before = problems_.size();
  path(key, file.path, doc);
  file.arrays = nullptr;
  if (file.path.empty() || problems_.size() > problems_before) return;
  const YamlNode* node = block_.node != nullptr ? block_.node->entry(key) : nullptr;
  const TextMark mark = node != nullptr ? node->mark : block_.mark;
  try {
    file.arrays = std::make_shared<const ModelArrays>(read_model(file.path));
  } catch (const InputError& error) {
    for (const Problem& problem : error.problems())
      problems_.push_back(
          {mark,
           {tree_.place(mark, path_of(key)), problem.place + ": " + problem.value, problem.expectation}});
  }
}

void YamlReader::program(std::string_view key, std::string& value, std::string_view doc) {
  path(key, value, doc);
  const YamlNode* node = block_.node != nullptr ? block_.node->entry(key) : nullptr;
  std::error_code ignored;
  if (node != nullptr && node->text.find('/') == std::string::npos &&
      !std::filesystem::is_regular_file(value, ignored))
    value = node->text;
}

std::optional<std::string> YamlReader::folder_of(std::string_view key) {
  const YamlNode* node = block_.node != nullptr ? block_.node->entry(key) : nullptr;
  if (node == nullptr) return std::nullopt;
  std::filesystem::path folder = std::filesystem::current_path();
  if (node->mark.line > 0 && !folder_.empty()) folder /= folder_;
  return folder.lexically_normal().string();
}

void YamlReader::choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
                        std::string_view) {
  // A block whose name is no option, such as a detector's, needs this key: the name may be a slip.
  const bool missing = block_.node == nullptr || block_.node->entry(key) == nullptr;
  const std::string close =
      missing ? nearest_name(block_.path.substr(block_.path.rfind('.') + 1), options) : std::string();
  const YamlNode* node =
      take(key, expectation_of(options) +
                    (close.empty() ? "" : "; did you mean the name " + close + " for the block?"));
  if (node == nullptr) return;
  const bool known = std::find(options.begin(), options.end(), node->text) != options.end();
  if (node->kind == Kind::scalar && known) {
    value = node->text;
  } else {
    refuse(*node, path_of(key), expectation_of(options));
  }
}

void YamlReader::numbers(std::string_view key, std::span<double> values, Range range, std::string_view) {
  const YamlNode* node = take(key, one_or_list(values.size(), "finite numbers", range));
  if (node == nullptr) return;
  if (const auto read = list(*node, path_of(key), values.size(), range)) {
    std::copy(read->begin(), read->end(), values.begin());
  }
}

std::vector<std::string> YamlReader::section_keys(std::vector<std::string> current) {
  return block_.node != nullptr ? block_.node->keys : current;
}

bool YamlReader::has_section(std::string_view key, bool present) {
  const bool given = block_.node != nullptr && block_.node->entry(key) != nullptr;
  if (!given && !present) block_.known.emplace_back(key);
  return given || present;
}

std::optional<std::string> YamlReader::file(std::string_view key, std::string_view) {
  constexpr std::string_view expectation = "the name of a file";
  const YamlNode* node = take(key, std::string(expectation));
  if (node == nullptr) return std::nullopt;
  if (node->kind != Kind::scalar || node->text.empty()) {
    refuse(*node, path_of(key), std::string(expectation));
    return std::nullopt;
  }
  if (node->mark.line == 0 || folder_.empty() || node->text.front() == '/') return node->text;
  return folder_ + "/" + node->text;
}

std::optional<std::vector<std::string>> YamlReader::names(std::string_view key, std::string_view) {
  constexpr std::string_view expectation = "a list of names, each once, such as [pan, tilt]";
  const YamlNode* node = take(key, std::string(expectation));
  if (node == nullptr) return std::nullopt;
  std::vector<std::string> found;
  bool valid = node->kind == Kind::list && !node->items.empty();
  for (const YamlNode& item : node->items) {
    valid = valid && item.kind == Kind::scalar && std::ranges::count(found, item.text) == 0;
    found.push_back(item.text);
  }
  if (valid) return found;
  refuse(*node, path_of(key), std::string(expectation));
  return std::nullopt;
}

std::optional<std::string> YamlReader::word(std::string_view key, std::string_view, std::string_view) {
  const YamlNode* node = take(key, "text");
  if (node == nullptr) return std::nullopt;
  if (node->kind == Kind::scalar && !node->text.empty()) return node->text;
  refuse(*node, path_of(key), "text");
  return std::nullopt;
}

std::optional<double> YamlReader::alternative(std::string_view key, Range range, std::string_view) {
  const YamlNode* node = take(key, expectation_of(range, "a finite number"));
  return node != nullptr ? number(*node, path_of(key), range) : std::nullopt;
}

void YamlReader::point_list(std::string_view key, std::vector<double>& values, std::size_t dimension,
                            Range range, std::string_view) {
  const std::string expectation =
      one_or_list(0, "points, each of " + std::to_string(dimension) + " finite numbers", range);
  const YamlNode* node = take(key, expectation);
  if (node == nullptr) return;
  if (node->kind != Kind::list) {
    refuse(*node, path_of(key), expectation);
    return;
  }
  std::vector<double> points;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const std::string path = path_of(key) + "[" + std::to_string(i) + "]";
    if (const auto point = list(node->items[i], path, dimension, range))
      points.insert(points.end(), point->begin(), point->end());
  }
  if (points.size() == node->items.size() * dimension) values = std::move(points);
}

void YamlReader::section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
                         std::string_view) {
  constexpr std::string_view expectation = "a block of keys";
  const std::size_t problems_before = problems_.size();
  const YamlNode* node = take(key, std::string(expectation));
  if (node != nullptr && node->kind != Kind::map) refuse(*node, path_of(key), std::string(expectation));
  if (problems_.size() > problems_before || (node != nullptr && node->kind != Kind::map)) return;

  const TextMark mark = node != nullptr && node->mark.line > 0 ? node->mark : block_.mark;
  Block outer = std::exchange(block_, Block{node, mark, path_of(key), {}, problems_before});
  describe_section(*this);
  report_unknown();
  block_ = std::move(outer);
}

void YamlReader::require(bool holds, std::string_view key, std::string_view found,
                         std::string_view expectation) {
  if (holds || problems_.size() > block_.problems_before) return;
  const YamlNode* node = block_.node != nullptr ? block_.node->entry(key) : nullptr;
  const TextMark mark = node != nullptr ? node->mark : block_.mark;
  const std::string path = path_of(key);
  const std::string place = node != nullptr || mark.line > 0 ? tree_.place(mark, path) : path;
  problems_.push_back({mark, {place, std::string(found), std::string(expectation)}});
}

void YamlReader::report_unknown() {
  for (const std::string& path : tree_.not_there) {
    const std::size_t key = path.rfind('.') + 1;  // 0 for a path of one word
    if (path.substr(0, key == 0 ? 0 : key - 1) == block_.path) report_if_unknown(path.substr(key), {});
  }
  if (block_.node == nullptr) return;
  for (std::size_t i = 0; i < block_.node->keys.size(); ++i)
    report_if_unknown(block_.node->keys[i], block_.node->items[i].mark);
}

void YamlReader::report_if_unknown(const std::string& key, TextMark mark) {
  if (std::find(block_.known.begin(), block_.known.end(), key) != block_.known.end()) return;
  if (const auto renamed = new_key_of(path_of(key))) {
    problems_.push_back({mark,
                         {tree_.place(mark, path_of(key)), "a key that was renamed",
                          *renamed + "; `saccade migrate FILE` rewrites old keys"}});
    return;
  }
  const std::string close = nearest_name(key, block_.known);
  const std::string expectation = block_.known.empty() ? "no keys here"
                                  : close.empty()      ? expectation_of(block_.known)
                                                       : "a known key; did you mean " + close + "?";
  problems_.push_back({mark, {tree_.place(mark, path_of(key)), "an unknown key", expectation}});
}

void YamlReader::finish() {
  report_unknown();
  throw_if_any(std::move(problems_));
}

}  // namespace saccade
