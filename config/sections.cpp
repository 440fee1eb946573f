#include "config/sections.h"

#include <algorithm>

#include "config/scenario.h"

namespace saccade {
namespace {

/// The row whose selecting key the block has; the block's name where it has none.
std::string row_for(const std::string& name, const YamlNode& block, const DetectorRegistry& registry) {
  for (const DetectorRow& row : registry.rows()) {
    if (!row.selecting_key.empty() && block.find(row.selecting_key) != nullptr) return row.name;
  }
  return name;
}

}  // namespace

NamedDetectors named_detectors_in(const YamlTree& tree, const DetectorRegistry& registry,
                                  std::vector<std::string>& required) {
  NamedDetectors detectors;
  const YamlNode* block = tree.root.find("detectors");
  if (block == nullptr) return detectors;
  for (std::size_t i = 0; i < block->keys.size(); ++i) {
    const std::string& name = block->keys[i];
    const YamlNode* preset = block->items[i].find("preset");
    const std::string start = preset != nullptr ? preset->text : row_for(name, block->items[i], registry);
    if (preset == nullptr && !registry.has(start)) required.push_back("detectors." + name + ".preset");
    detectors.emplace_back(name, registry.config(registry.has(start) ? start : registry.names().front()));
  }
  return detectors;
}

void describe_detectors(FieldVisitor& v, NamedDetectors& detectors) {
  v.section(
      "detectors",
      [&](FieldVisitor& block) {
        for (auto& [name, config] : detectors) {
          block.section(
              name, [&config = config](FieldVisitor& w) { describe(w, config); }, "a detector");
          block.require(is_name(name), name, "such a name", name_expectation);
        }
      },
      "detectors that see the events, by name");
}

void describe_name(FieldVisitor& v, std::string& name, std::string_view doc) {
  constexpr std::size_t longest = 64;
  v.text("name", name, doc);
  const bool is_file_name = !name.empty() && name.size() <= longest && name.front() != '.' &&
                            std::none_of(name.begin(), name.end(), [](char c) {
                              return c == '/' || c == '\\' || (c >= 0 && c < ' ') || c == 0x7f;
                            });
  v.require(is_file_name, "name", name.empty() ? "\"\"" : name,
            "the name of a folder: at most 64 bytes, without / and \\, no dot at its start");
}

void describe_calibration(FieldVisitor& v, MountedCamera& calibration, int camera) {
  if (const auto file = v.file(
          "file", "file with the values of the keys below, of `saccade calibrate`, OpenCV, ROS or Kalibr"))
    calibration = read_calibration(*file, camera);
  describe(v, calibration);
}

}  // namespace saccade
