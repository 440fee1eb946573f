#include <algorithm>

#include "config/key_reference.h"

namespace saccade {
namespace {

/// Type, unit, range or words, default, condition in one line.
std::string facts_of(const KeyRow& row) {
  std::string text = row.type;
  if (!row.unit.empty()) text += ", " + row.unit;
  if (!row.takes.empty()) text += row.type == "word" ? ": " + row.takes : " " + row.takes;
  if (!row.default_value.empty()) text += "; default " + row.default_value;
  if (!row.condition.empty()) text += "; only with " + row.condition;
  return text;
}

/// Words of a text, wrapped after `width` columns; each line starts with `indent` spaces.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::string lines;
  std::size_t column = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::size_t length = end - begin;
    if (column > 0 && column + 1 + length > width) {
      lines += '\n';
      column = 0;
    }
    lines += column == 0 ? std::string(indent, ' ') : " ";
    column += (column == 0 ? indent : 1) + length;
    lines.append(text, begin, length);
    begin = end + 1;
  }
  return lines + "\n";
}

std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2))
    text.insert(at, "\\");
  return text;
}

}  // namespace

std::string keys_as_text(const std::vector<KeyRow>& rows, std::size_t width) {
  std::string text;
  for (const KeyRow& row : rows) {
    text += row.path + "\n";
    text += wrapped(row.doc, 4, width);
    text += wrapped(facts_of(row), 4, width);
  }
  return text;
}

std::string keys_as_markdown(const std::vector<KeyRow>& rows, const std::string& heading) {
  const bool defaults =
      std::ranges::any_of(rows, [](const KeyRow& row) { return !row.default_value.empty(); });
  std::string text =
      "| " + heading +
      (defaults ? " | takes | default | |\n|---|---|---|---|\n" : " | type | |\n|---|---|---|\n");
  for (const KeyRow& row : rows) {
    std::string takes = row.type == "word" ? row.takes : row.type;
    if (row.type != "word" && !row.takes.empty()) takes += " " + row.takes;
    if (!row.unit.empty()) takes += ", " + row.unit;
    const std::string value = row.default_value.empty() ? "" : "`" + row.default_value + "`";
    const std::string condition = row.condition.empty() ? "" : " (only with `" + row.condition + "`)";
    text += "| `" + row.path + "` | " + cell(takes) + " | " + (defaults ? cell(value) + " | " : "") +
            cell(row.doc + condition) + " |\n";
  }
  return text;
}

}  // namespace saccade
