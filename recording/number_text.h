#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

namespace saccade {

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

/// The text without the byte order mark that some programs write in front of UTF-8; for the first line of a file.
[[nodiscard]] constexpr std::string_view without_mark(std::string_view text) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

/// Appends a time of 0 us or later in seconds, with six decimals.
inline void append_seconds(std::string& text, std::int64_t t_us) {
  append_number(text, t_us / 1'000'000);
  const std::string micros = std::to_string(1'000'000 + t_us % 1'000'000);
  text += '.';
  text.append(micros, 1);
}

}  // namespace saccade
