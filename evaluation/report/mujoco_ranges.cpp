#include "evaluation/report/mujoco_ranges.h"

#include <array>
#include <charconv>
#include <map>

namespace saccade {
namespace {

struct MujocoRange {
  int major;  ///< of its first version
  int minor;
  std::string_view name;
};
constexpr std::array<MujocoRange, 2> mujoco_ranges{{{2, 0, "2.2 to 2.3"}, {3, 0, "3.0 and newer"}}};

constexpr std::string_view before_version = "MuJoCo ";

/// "3.5.0" in "saccade 0.1.0 (9b6774e), MuJoCo 3.5.0, served".
std::string_view mujoco_version_in(std::string_view text) {
  const std::size_t at = text.find(before_version);
  if (at == std::string_view::npos) return {};
  text.remove_prefix(at + before_version.size());
  return text.substr(0, text.find_first_not_of("0123456789."));
}

}  // namespace

std::string_view mujoco_range(std::string_view text) {
  const std::string_view version = mujoco_version_in(text);
  int major = 0;
  int minor = 0;
  const char* const end = version.data() + version.size();
  const auto [dot, error] = std::from_chars(version.data(), end, major);
  if (error != std::errc() || dot == end || std::from_chars(dot + 1, end, minor).ec != std::errc()) return {};
  std::string_view name;
  for (const MujocoRange& range : mujoco_ranges) {
    if (major > range.major || (major == range.major && minor >= range.minor)) name = range.name;
  }
  return name;
}

std::string mujoco_warning(std::span<const std::string> texts) {
  std::map<std::string_view, std::string_view> version_of_range;
  for (const std::string& text : texts) {
    if (const std::string_view range = mujoco_range(text); !range.empty())
      version_of_range.try_emplace(range, mujoco_version_in(text));
  }
  if (version_of_range.size() < 2) return {};
  std::string versions;
  for (const auto& [range, version] : version_of_range)
    versions += (versions.empty() ? "" : " and ") + std::string(version);
  return "runs of MuJoCo " + versions +
         ": single events of equal scenarios and seeds differ between them, and so do figures "
         "(docs/install.md)";
}

}  // namespace saccade
