#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace saccade {

/// The number, or null, at a path of metrics.json such as "gaze.in_view_ratio"; nullptr where there is none.
inline const nlohmann::json* find_figure(const nlohmann::json& metrics, const std::string& path) {
  const nlohmann::json* node = &metrics;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const auto child = node->find(path.substr(begin, end - begin));
    if (child == node->end()) return nullptr;
    node = &*child;
    begin = end + 1;
  }
  return node->is_number() || node->is_null() ? node : nullptr;
}

}  // namespace saccade
