#pragma once

#include "control/controller_registry.h"
#include "core/detector_registry.h"

namespace saccade {

/// Adds the rows `python`, `command` and `socket`: detectors outside of this program (docs/external_detectors.md). The keys of the
/// same names select them where an entry has no `preset`.
void add_external_detectors(DetectorRegistry& registry);

/// Adds the rows `python`, `command` and `socket`: gaze controllers outside of this program (docs/external_controllers.md).
void add_external_controllers(ControllerRegistry& registry);

}  // namespace saccade
