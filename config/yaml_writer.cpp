#include "config/yaml_writer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/yaml_tree.h"

namespace saccade {
namespace {

/// Words stay plain; whatever a reader of YAML could take for something else is put in quotes.
std::string scalar(std::string_view text) {
  constexpr std::array<std::string_view, 11> taken = {"true", "false", "null", "yes", "no", "on",
                                                      "off",  "y",     "n",    "nan", "inf"};
  std::string lowered(text);
  std::transform(text.begin(), text.end(), lowered.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; };
  const bool word =
      !text.empty() && is_letter(lowered[0]) && std::all_of(lowered.begin(), lowered.end(), [&](char c) {
        return is_letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '/';
      });
  const bool plain = word && std::find(taken.begin(), taken.end(), lowered) == taken.end();
  return plain ? std::string(text) : quote_yaml(text);
}

std::string number(double value) {
  SACCADE_CHECK(std::isfinite(value));
  return text_of(value);
}

std::string list(std::span<const double> values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + number(value);
  return "[" + text + "]";
}

}  // namespace

void YamlWriter::line(std::string_view key, std::string_view value, std::string_view doc,
                      std::string_view takes) {
  yaml_ += std::string(2 * depth_, ' ') + scalar(key) + ":";
  if (!value.empty()) yaml_ += " " + std::string(value);
  if (comments_ == Comments::all) {
    yaml_ += "  # " + std::string(doc);
    if (!takes.empty()) yaml_ += "; " + std::string(takes);
  }
  yaml_ += '\n';
}

void YamlWriter::real(std::string_view key, double& value, Range range, std::string_view doc) {
  line(key, number(value), doc, expectation_of(range, "a number"));
}

void YamlWriter::integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) {
  line(key, std::to_string(value), doc, expectation_of(range, "a whole number"));
}

void YamlWriter::boolean(std::string_view key, bool& value, std::string_view doc) {
  line(key, value ? "true" : "false", doc, "true or false");
}

void YamlWriter::text(std::string_view key, std::string& value, std::string_view doc) {
  line(key, scalar(value), doc, "text");
}

void YamlWriter::choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
                        std::string_view doc) {
  line(key, scalar(value), doc, expectation_of(options));
}

void YamlWriter::numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) {
  line(key, list(values), doc,
       expectation_of(range, "a list of " + std::to_string(values.size()) + " numbers"));
}

void YamlWriter::point_list(std::string_view key, std::vector<double>& values, std::size_t dimension,
                            Range range, std::string_view doc) {
  const std::string takes =
      expectation_of(range, "a list of points, each of " + std::to_string(dimension) + " numbers");
  line(key, values.empty() ? "[]" : "", doc, takes);
  for (std::size_t i = 0; i < values.size(); i += dimension) {
    yaml_ += std::string(2 * (depth_ + 1), ' ') + "- " +
             list(std::span<const double>(values).subspan(i, dimension)) + "\n";
  }
}

void YamlWriter::section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
                         std::string_view doc) {
  YamlWriter inner(comments_);
  inner.depth_ = depth_ + 1;
  describe_section(inner);
  line(key, inner.yaml_.empty() ? "{}" : "", doc, "");
  yaml_ += inner.yaml_;
}

}  // namespace saccade
