#pragma once

#include "core/detector_registry.h"

namespace saccade {

/// The detectors that saccade ships (docs/detectors.md has their sources).
[[nodiscard]] DetectorRegistry built_in_detectors();

}  // namespace saccade
