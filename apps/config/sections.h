#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/config/yaml_tree.h"
#include "core/camera.h"
#include "core/detector_registry.h"

namespace saccade {

/// Detectors by the name they have in a run, in file order.
using NamedDetectors = std::vector<std::pair<std::string, DetectorConfig>>;

/// What scenarios and robot files have in common.

/// The detectors that the block `detectors` names, with their presets' values; a name that is no preset needs
/// the key `preset`, which is added to `required`.
[[nodiscard]] NamedDetectors named_detectors_in(const YamlTree& tree, const DetectorRegistry& registry,
                                                std::vector<std::string>& required);
/// The block `detectors`.
void describe_detectors(FieldVisitor& v, NamedDetectors& detectors);

/// What the key `file` of the block `name` names, as read_calibration reads it; the key is taken out of the tree. The
/// file is relative to `folder`, from --set to the working directory. None without that key. Throws InputError.
[[nodiscard]] std::optional<MountedCamera> calibration_from_file(YamlTree& tree,
                                                                 const std::filesystem::path& folder,
                                                                 const std::string& name);

}  // namespace saccade
