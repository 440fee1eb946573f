#include "recording/text_header.h"

#include <algorithm>
#include <array>

#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::string_view needed_letters = "txyp";
constexpr int largest_text_length_px = 1 << 16;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

std::string_view without_quotes(std::string_view text) {
  constexpr std::string_view around = " \t\r\"'";
  text.remove_prefix(std::min(text.find_first_not_of(around), text.size()));
  return text.substr(0, text.find_last_not_of(around) + 1);
}

char letter_of(EventColumn column) { return "txypc"[static_cast<std::size_t>(column)]; }

}  // namespace

std::vector<std::string_view> names_in(std::string_view line) {
  std::vector<std::string_view> names;
  const auto separators = line.find_first_of(",;") != std::string_view::npos          ? std::string_view(",;")
                          : without_quotes(line).find('\t') != std::string_view::npos ? std::string_view("\t")
                                                                                      : std::string_view();
  if (!separators.empty()) {
    while (true) {
      const std::size_t end = line.find_first_of(separators);
      names.push_back(without_quotes(line.substr(0, end)));
      if (end == std::string_view::npos) return names;
      line.remove_prefix(end + 1);
    }
  }
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t begin = i;
    while (i < line.size() && !is_blank(line[i])) ++i;
    const std::string_view word = line.substr(begin, i - begin);
    if (!names.empty() && (word.starts_with('[') || word.starts_with('('))) {
      names.back() = {names.back().data(), static_cast<std::size_t>(line.data() + i - names.back().data())};
    } else if (!word.empty()) {
      names.push_back(without_quotes(word));
    }
    while (i < line.size() && is_blank(line[i])) ++i;
  }
  return names;
}

bool is_line_of_names(std::string_view line) {
  const std::vector<std::string_view> names = names_in(line);
  return names.size() >= needed_letters.size() && std::ranges::all_of(names, [](std::string_view name) {
           return name.empty() || is_letter(name.front()) || name.front() == '_';
         });
}

std::optional<TextColumns> named_columns(std::string_view line) {
  const std::vector<std::string_view> names = names_in(line);
  TextColumns columns;
  columns.letters.assign(names.size(), '_');
  const auto count = [&](char letter) { return std::ranges::count(columns.letters, letter); };
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (const auto named = event_column(names[i])) {
      columns.letters[i] = letter_of(named->column);
      if (named->column == EventColumn::t) columns.unit = named->unit;
    } else if (names[i] == "c") {
      columns.letters[i] = 'c';
    }
  }
  for (const char letter : needed_letters) {
    if (count(letter) > 0) continue;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const bool begins = !names[i].empty() && (names[i].front() | 0x20) == letter;
      if (columns.letters[i] == '_' && begins) columns.letters[i] = letter;
    }
  }
  if (std::ranges::any_of(needed_letters, [&](char letter) { return count(letter) != 1; }) || count('c') > 1)
    return std::nullopt;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (columns.letters[i] == '_') columns.unread.emplace_back(names[i]);
  }
  return columns;
}

std::optional<ImageSize> size_in_line(std::string_view line) {
  const std::vector<std::string_view> words = names_in(line);
  ImageSize size;
  if (words.size() != 2 || !parse_number(words[0], size.width) || !parse_number(words[1], size.height))
    return std::nullopt;
  const auto is_length = [](int px) { return px > 0 && px <= largest_text_length_px; };
  return is_length(size.width) && is_length(size.height) ? std::optional(size) : std::nullopt;
}

std::optional<ImageSize> geometry_in_comment(std::string_view line) {
  constexpr std::string_view key = "geometry";
  const std::size_t place = line.find(key);
  if (place == std::string_view::npos) return std::nullopt;
  line.remove_prefix(place + key.size());
  line.remove_prefix(std::min(line.find_first_not_of(":= \t"), line.size()));
  std::string numbers(without_quotes(line));
  std::ranges::replace_if(
      numbers, [](char c) { return c == 'x' || c == ','; }, ' ');
  return size_in_line(numbers);
}

}  // namespace saccade
