#include "core/config.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/model_arrays.h"

namespace saccade {

std::string text_of(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

std::string expectation_of(Range range, std::string_view kind) {
  const bool low = std::isfinite(range.min);
  const bool high = std::isfinite(range.max);
  std::string text(kind);
  if (low && high) return text + " in [" + text_of(range.min) + ", " + text_of(range.max) + "]";
  if (low) return text + " of at least " + text_of(range.min);
  if (high) return text + " of at most " + text_of(range.max);
  return text;
}

std::string expectation_of(const std::vector<std::string>& options) {
  std::string text = "one of ";
  for (std::size_t i = 0; i < options.size(); ++i) text += (i == 0 ? "" : ", ") + options[i];
  return text;
}

bool is_name(std::string_view text) {
  constexpr std::size_t longest = 64;
  const auto is_part = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !text.empty() && text.size() <= longest && std::all_of(text.begin(), text.end(), is_part);
}

void FieldVisitor::model(std::string_view key, ModelFile& file, std::string_view doc) {
  path(key, file.path, doc);
}

void FieldVisitor::when(bool holds, std::string_view, const std::function<void()>& describe_keys) {
  if (holds) describe_keys();
}

void FieldChecker::add(std::string_view key, std::string value, std::string expectation) {
  problems_.push_back({name_ + "." + std::string(key), std::move(value), std::move(expectation)});
}

void FieldChecker::real(std::string_view key, double& value, Range range, std::string_view) {
  if (!std::isfinite(value) || !range.contains(value)) {
    add(key, text_of(value), expectation_of(range, "a finite number"));
  }
}

void FieldChecker::integer(std::string_view key, std::int64_t& value, Range range, std::string_view) {
  if (!range.contains(static_cast<double>(value))) {
    add(key, std::to_string(value), expectation_of(range, "a whole number"));
  }
}

void FieldChecker::choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
                          std::string_view) {
  if (std::find(options.begin(), options.end(), value) == options.end()) {
    add(key, value.empty() ? "nothing" : value, expectation_of(options));
  }
}

void FieldChecker::numbers(std::string_view key, std::span<double> values, Range range, std::string_view) {
  for (double& value : values) real(key, value, range, {});
}

void FieldChecker::point_list(std::string_view key, std::vector<double>& values, std::size_t, Range range,
                              std::string_view) {
  numbers(key, values, range, {});
}

void FieldChecker::section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
                           std::string_view) {
  FieldChecker inner(name_ + "." + std::string(key));
  describe_section(inner);
  problems_.insert(problems_.end(), inner.problems_.begin(), inner.problems_.end());
}

void FieldChecker::require(bool holds, std::string_view key, std::string_view found,
                           std::string_view expectation) {
  if (!holds) add(key, std::string(found), std::string(expectation));
}

void FieldChecker::throw_if_any() const {
  if (!problems_.empty()) throw InputError(problems_);
}

}  // namespace saccade
