#pragma once

#include "core/detector_registry.h"

namespace saccade {

/// Adds the rows `python` and `command`: detectors outside of this program (docs/external_detectors.md). The keys of the
/// same names select them where an entry has no `preset`.
void add_external_detectors(DetectorRegistry& registry);

}  // namespace saccade
