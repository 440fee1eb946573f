#pragma once

#include "config/registry.h"
#include "core/detectors/built_in_detectors.h"

namespace saccade {

/// What saccade ships, as far as reading scenarios and recordings needs it: without the backends of robots.
inline Registry built_in() {
  Registry registry;
  registry.detectors = built_in_detectors();
  registry.controllers = built_in_controllers();
  registry.gates = built_in_gates();
  registry.formats = built_in_formats();
  return registry;
}

}  // namespace saccade
