#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace saccade {

inline std::string contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// How often `part` is in `text`, without overlaps.
inline std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string_view::npos; at += part.size()) ++n;
  return n;
}

/// A page without the text of its scripts: what it could load from elsewhere is in what remains.
inline std::string without_scripts(std::string_view html) {
  constexpr std::string_view open = "<script>";
  constexpr std::string_view close = "</script>";
  std::string rest;
  for (std::size_t at = 0; (at = html.find(open)) != std::string_view::npos;) {
    rest += html.substr(0, at);
    html.remove_prefix(std::min(html.find(close, at) + close.size(), html.size()));
  }
  return rest.append(html);
}

}  // namespace saccade
