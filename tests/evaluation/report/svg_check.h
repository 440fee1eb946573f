#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// What is wrong with the nesting of a piece of XML; empty when every element that opens also closes, in
/// order, and every attribute is quoted.
inline std::string nesting_problem(std::string_view xml) {
  std::vector<std::string> open;
  for (std::size_t at = 0; (at = xml.find('<', at)) != std::string_view::npos;) {
    const bool closes = xml.substr(at + 1, 1) == "/";
    std::size_t end = at + (closes ? 2 : 1);
    const std::size_t name_start = end;
    while (end < xml.size() && std::string_view(" \t\n/>").find(xml[end]) == std::string_view::npos) ++end;
    const std::string name(xml.substr(name_start, end - name_start));
    char quote = 0;
    for (; end < xml.size() && (quote != 0 || xml[end] != '>'); ++end) {
      if (quote == 0 && (xml[end] == '"' || xml[end] == '\'')) {
        quote = xml[end];
      } else if (xml[end] == quote) {
        quote = 0;
      } else if (xml[end] == '<') {
        return "'<' inside the tag " + name;
      }
    }
    if (end == xml.size()) return "the tag " + name + " does not end";
    if (closes) {
      if (open.empty() || open.back() != name) return "</" + name + "> closes nothing";
      open.pop_back();
    } else if (xml[end - 1] != '/') {
      open.push_back(name);
    }
    at = end;
  }
  return open.empty() ? "" : "<" + open.back() + "> does not close";
}

}  // namespace saccade
