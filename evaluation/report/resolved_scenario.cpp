#include "evaluation/report/resolved_scenario.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "recording/run_file_names.h"

namespace saccade {
namespace {

constexpr std::size_t max_differences = 3;
constexpr std::string_view version_start = "# saccade ";

bool is_in_section(std::string_view key, std::string_view section) {
  return key == section || (key.starts_with(section) && key[section.size()] == '.');
}

bool changes_no_score(std::string_view key) {
  return key == "seed" || key == "description" || key == "run.threads" || is_in_section(key, "output") ||
         is_in_section(key, "expect");
}

/// Keys that enclose a line, each with its indentation.
using KeyPath = std::vector<std::pair<std::size_t, std::string>>;

std::string joined(const KeyPath& path) {
  std::string key;
  for (const auto& [indentation, name] : path) key += (key.empty() ? "" : ".") + name;
  return key;
}

/// Adds the names and digests of the files that a run read.
void add_file_contents(const std::filesystem::path& run_folder, ResolvedKeys& keys) {
  for (const char* name : {run_file::metrics, run_file::figures_json}) {
    std::ifstream file(run_folder / name, std::ios::binary);
    if (!file) continue;
    const auto json = nlohmann::json::parse(file, nullptr, false);
    if (!json.is_object()) continue;
    for (const auto& read : json.value("files", nlohmann::json::array())) {
      const std::filesystem::path path = read.value("file", "");
      std::string& value = keys[read.value("key", "") + ".contents"];
      value += (value.empty() ? "" : ", ") + path.filename().string() + " " + read.value("digest", "");
    }
    return;
  }
}

}  // namespace

ResolvedKeys resolved_keys(const std::string& yaml) {
  ResolvedKeys keys;
  KeyPath path;
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(version_start)) keys["version"] = line.substr(2, line.find(';') - 2);
    const std::size_t indentation = line.find_first_not_of(' ');
    if (indentation == std::string::npos || line[indentation] == '#') continue;
    std::string content = line.substr(indentation);
    if (!content.starts_with("- ")) {
      while (!path.empty() && path.back().first >= indentation) path.pop_back();
      const std::size_t colon = content.find(": ");
      const bool has_value = colon != std::string::npos;
      path.emplace_back(indentation,
                        content.substr(0, has_value ? colon : content.find_last_not_of(": ") + 1));
      content = has_value ? content.substr(colon + 2) : std::string();
    }
    const std::string key = joined(path);
    if (content.empty() || changes_no_score(key)) continue;
    std::string& value = keys[key];
    value += (value.empty() ? "" : " ") + content;
  }
  return keys;
}

ResolvedKeys read_resolved_keys(const std::filesystem::path& run_folder) {
  for (const char* name : {"scenario.yaml", "detectors.yaml"}) {
    std::ifstream file(run_folder / name, std::ios::binary);
    if (!file) continue;
    ResolvedKeys keys = resolved_keys({std::istreambuf_iterator<char>(file), {}});
    add_file_contents(run_folder, keys);
    return keys;
  }
  return {};
}

std::string difference_text(const ResolvedKeys& a, const ResolvedKeys& b) {
  std::vector<std::string> parts;
  for (const auto& [key, value] : b) {
    const auto other = a.find(key);
    if (other == a.end() || other->second != value) parts.push_back(key + "=" + value);
  }
  for (const auto& [key, value] : a) {
    if (!b.contains(key)) parts.push_back("without " + key);
  }
  std::string text;
  for (std::size_t i = 0; i < std::min(parts.size(), max_differences); ++i) {
    text += (i > 0 ? ", " : "") + parts[i];
  }
  return parts.size() > max_differences ? text + ", ..." : text;
}

std::string world_text(const ResolvedKeys& keys) {
  std::string text;
  for (const auto& [key, value] : keys) {
    if (!is_in_section(key, "detectors") && !is_in_section(key, "gaze")) text += key + "=" + value + "\n";
  }
  return text;
}

}  // namespace saccade
