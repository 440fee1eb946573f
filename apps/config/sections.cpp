#include "apps/config/sections.h"

#include <algorithm>

#include "apps/config/scenario.h"

namespace saccade {
NamedDetectors named_detectors_in(const YamlTree& tree, const DetectorRegistry& registry,
                                  std::vector<std::string>& required) {
  NamedDetectors detectors;
  const YamlNode* block = tree.root.find("detectors");
  if (block == nullptr) return detectors;
  for (std::size_t i = 0; i < block->keys.size(); ++i) {
    const std::string& name = block->keys[i];
    const YamlNode* preset = block->items[i].find("preset");
    if (preset == nullptr && !registry.has(name)) required.push_back("detectors." + name + ".preset");
    const std::string& start = preset != nullptr ? preset->text : name;
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
        }
      },
      "detectors that see the events, by name");
}

std::optional<MountedCamera> calibration_from_file(YamlTree& tree, const std::filesystem::path& folder,
                                                   const std::string& name) {
  const auto block = std::find(tree.root.keys.begin(), tree.root.keys.end(), name);
  if (block == tree.root.keys.end()) return std::nullopt;
  YamlNode& calibration = tree.root.items[static_cast<std::size_t>(block - tree.root.keys.begin())];
  const auto at = std::find(calibration.keys.begin(), calibration.keys.end(), "file");
  if (at == calibration.keys.end()) return std::nullopt;
  const auto index = at - calibration.keys.begin();
  const YamlNode file = calibration.items[static_cast<std::size_t>(index)];
  if (file.kind != YamlNode::Kind::scalar || file.text.empty()) {
    throw InputError(tree.place(file.mark, name + ".file"), file.found(), "the name of a file");
  }
  calibration.keys.erase(at);
  calibration.items.erase(calibration.items.begin() + index);
  return read_calibration(file.mark.line == 0 ? std::filesystem::path(file.text) : folder / file.text);
}

}  // namespace saccade
