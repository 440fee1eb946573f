#include "config/key_reference.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "config/source_keys.h"

namespace saccade {
namespace {

/// The values that are given to keys, by path.
using Given = std::map<std::string, std::string>;

std::string joined(const std::vector<std::string>& words, std::string_view separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : std::string(separator)) + word;
  return text;
}

std::string range_text(Range range) {
  const std::string text = expectation_of(range, "");
  return text.empty() ? text : text.substr(text.find_first_not_of(' '));
}

std::string list_text(std::span<const double> values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + text_of(value);
  return "[" + text + "]";
}

/// A row, and the words that its key takes where it is a choice.
struct Listed {
  KeyRow row;
  std::vector<std::string> words;
};

/// Lists the keys that are visited while `given` holds.
class KeyLister final : public FieldVisitor, public SourceKeys {
 public:
  explicit KeyLister(const Given& given) : given_(given) {}

  [[nodiscard]] std::vector<Listed> take() && { return std::move(rows_); }

  void real(std::string_view key, double& value, Range range, std::string_view doc) override {
    add(key, "number", range_text(range), text_of(value), doc);
  }
  void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) override {
    add(key, "whole number", range_text(range), std::to_string(value), doc);
  }
  void boolean(std::string_view key, bool& value, std::string_view doc) override {
    add(key, "true or false", "", value ? "true" : "false", doc, {"false", "true"});
    if (const auto it = given_.find(path_of(key)); it != given_.end()) value = it->second == "true";
  }
  void text(std::string_view key, std::string& value, std::string_view doc) override {
    add(key, "text", "", value, doc);
  }
  void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
              std::string_view doc) override {
    add(key, "word", joined(options, ", "), value, doc, options);
    if (const auto it = given_.find(path_of(key)); it != given_.end()) value = it->second;
  }
  void numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) override {
    add(key, "list of " + std::to_string(values.size()) + " numbers", range_text(range), list_text(values),
        doc);
  }
  void point_list(std::string_view key, std::vector<double>& values, std::size_t dimension, Range range,
                  std::string_view doc) override {
    std::string points;
    for (std::size_t i = 0; i < values.size(); i += dimension)
      points += (i == 0 ? "" : ", ") + list_text(std::span<const double>(values).subspan(i, dimension));
    add(key, "list of points of " + std::to_string(dimension) + " numbers", range_text(range),
        "[" + points + "]", doc);
  }
  void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
               std::string_view) override {
    const std::string outer = std::exchange(prefix_, path_of(key) + ".");
    describe_section(*this);
    prefix_ = outer;
  }
  std::vector<std::string> section_keys(std::vector<std::string> current) override {
    return current.empty() ? std::vector<std::string>{"NAME"} : current;
  }
  bool has_section(std::string_view, bool) override { return true; }
  std::optional<std::string> file(std::string_view key, std::string_view doc) override {
    add(key, "file", "", "", doc);
    return std::nullopt;
  }
  std::optional<std::vector<std::string>> names(std::string_view key, std::string_view doc) override {
    add(key, "list of names", "", "", doc);
    return std::nullopt;
  }
  std::optional<std::string> word(std::string_view key, std::string_view usual,
                                  std::string_view doc) override {
    add(key, "text", "", std::string(usual), doc);
    return std::nullopt;
  }
  std::optional<double> alternative(std::string_view key, Range range, std::string_view doc) override {
    add(key, "number", range_text(range), "", doc);
    return std::nullopt;
  }
  void require(bool, std::string_view, std::string_view, std::string_view) override {}

 private:
  [[nodiscard]] std::string path_of(std::string_view key) const { return prefix_ + std::string(key); }
  void add(std::string_view key, std::string type, std::string takes, std::string value, std::string_view doc,
           std::vector<std::string> words = {}) {
    rows_.push_back({{path_of(key), std::move(type), unit_of_key(key), std::move(takes), std::move(value), "",
                      std::string(doc)},
                     std::move(words)});
  }

  const Given& given_;
  std::string prefix_;
  std::vector<Listed> rows_;
};

std::vector<Listed> listed(const std::function<void(FieldVisitor&)>& describe_keys, const Given& given) {
  KeyLister lister(given);
  describe_keys(lister);
  return std::move(lister).take();
}

/// A key that was found, and the values under which it was.
struct Found {
  Listed listed;
  Given given;
};

}  // namespace

std::vector<KeyRow> list_keys(const std::function<void(FieldVisitor&)>& describe_keys) {
  std::vector<Found> found;
  for (Listed& row : listed(describe_keys, {})) found.push_back({std::move(row), {}});
  const auto position = [&](const std::string& path) {
    return std::find_if(found.begin(), found.end(),
                        [&](const Found& f) { return f.listed.row.path == path; });
  };
  std::set<std::string> tried;
  const auto next_choice = [&] {
    return std::find_if(found.begin(), found.end(), [&](const Found& f) {
      const std::string& path = f.listed.row.path;
      return !f.listed.words.empty() && path != "preset" && !path.ends_with(".preset") &&
             !tried.contains(path);
    });
  };
  for (auto it = next_choice(); it != found.end(); it = next_choice()) {
    const Found choice = *it;
    const std::string& path = choice.listed.row.path;
    tried.insert(path);
    std::map<std::string, std::vector<std::string>> words_with;  // by path of the key that is there
    for (const std::string& word : choice.listed.words) {
      Given given = choice.given;
      given[path] = word;
      const std::vector<Listed> rows = listed(describe_keys, given);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        words_with[rows[k].row.path].push_back(word);
        if (position(rows[k].row.path) != found.end()) continue;
        // Before the next row that is known already, so that the order is that of the description.
        auto place = found.end();
        for (std::size_t next = k + 1; next < rows.size() && place == found.end(); ++next)
          place = position(rows[next].row.path);
        found.insert(place, {rows[k], given});
      }
    }
    const std::string key = path.substr(path.rfind('.') + 1);
    for (Found& f : found) {
      const auto words = words_with.find(f.listed.row.path);
      if (words == words_with.end() || words->second.size() == choice.listed.words.size()) continue;
      std::string& condition = f.listed.row.condition;
      condition += (condition.empty() ? "" : ", or ") + key + ": " + joined(words->second, " or ");
    }
  }
  std::vector<KeyRow> rows;
  for (Found& f : found) rows.push_back(std::move(f.listed.row));
  return rows;
}

std::string unit_of_key(std::string_view key) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 20> units = {{
      {"_deg_s2", "deg/s²"}, {"_deg_s", "deg/s"},   {"_deg", "deg"},   {"_rad_s", "rad/s"},
      {"_rad", "rad"},       {"_m_s2", "m/s²"},     {"_m_s", "m/s"},   {"_px_s", "px/s"},
      {"_us", "us"},         {"_ms", "ms"},         {"_s", "s"},       {"_mm", "mm"},
      {"_um", "um"},         {"_m", "m"},           {"_px", "px"},     {"_px2", "px²"},
      {"_hz", "Hz"},         {"_events", "events"}, {"_bits", "bits"}, {"_decades", "decades"},
  }};
  for (const auto& [ending, unit] : units) {
    if (key.ends_with(ending)) return std::string(unit);
  }
  return {};
}

}  // namespace saccade
