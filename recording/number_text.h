#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace saccade::inline v0_1 {

/// Appends the shortest text that reads back as the same number.
template <class T>
void append_number(std::string& text, T value) {
  char buffer[32];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

/// Whether a character separates words in a line of text.
[[nodiscard]] inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// True where the whole text is one number that T holds.
template <class T>
[[nodiscard]] bool parse_number(std::string_view text, T& value) {
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end;
}

/// True where the whole text is a time in seconds, less than 9e12; it is rounded to the nearest us, exactly: no double
/// on the way unless there is an exponent.
[[nodiscard]] inline bool parse_seconds(std::string_view text, std::int64_t& t_us) {
  constexpr double longest_s = 9e12;
  if (text.find_first_of("eE") != std::string_view::npos) {
    double seconds = 0.0;
    if (!parse_number(text, seconds) || !(std::abs(seconds) < longest_s)) return false;
    t_us = std::llround(seconds * 1e6);
    return true;
  }
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string_view whole = text.substr(0, point);
  const std::string_view fraction = text.substr(std::min(point + 1, text.size()));
  if (whole.empty() && fraction.empty()) return false;
  if (!std::all_of(whole.begin(), whole.end(), is_digit)) return false;
  if (!std::all_of(fraction.begin(), fraction.end(), is_digit)) return false;
  std::int64_t seconds = 0;
  if (!whole.empty() && !parse_number(whole, seconds)) return false;
  if (static_cast<double>(seconds) >= longest_s) return false;
  std::int64_t micros = 0;
  for (std::size_t i = 0; i < 6; ++i) micros = micros * 10 + (i < fraction.size() ? fraction[i] - '0' : 0);
  if (fraction.size() > 6 && fraction[6] >= '5') ++micros;
  t_us = seconds * 1'000'000 + micros;
  if (negative) t_us = -t_us;
  return true;
}

/// Appends a time of 0 us or later in seconds, with six decimals.
inline void append_seconds(std::string& text, std::int64_t t_us) {
  append_number(text, t_us / 1'000'000);
  const std::string micros = std::to_string(1'000'000 + t_us % 1'000'000);
  text += '.';
  text.append(micros, 1);
}

}  // namespace saccade::inline v0_1
