#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/yaml_tree.h"
#include "core/camera.h"
#include "core/detector_registry.h"

namespace saccade {

/// Detectors by the name they have in a run, in file order.
using NamedDetectors = std::vector<std::pair<std::string, DetectorConfig>>;

/// What scenarios and robot files have in common.

/// The detectors that the block `detectors` names, with their presets' values. A name that is no preset needs the key
/// `preset`, which is added to `required`, or a key that selects one (DetectorRow::selecting_key).
[[nodiscard]] NamedDetectors named_detectors_in(const YamlTree& tree, const DetectorRegistry& registry,
                                                std::vector<std::string>& required);
/// The block `detectors`.
void describe_detectors(FieldVisitor& v, NamedDetectors& detectors);

/// The key `name` of a scenario or robot file, which names its run folder as well.
void describe_name(FieldVisitor& v, std::string& name, std::string_view doc);

/// The keys of the calibration of the left camera (0) or the right one (1): `file`, which read_calibration() reads, then those
/// of MountedCamera.
void describe_calibration(FieldVisitor& v, MountedCamera& calibration, int camera);

}  // namespace saccade
