#pragma once

#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "core/detector_registry.h"
#include "recording/format_registry.h"
#include "robot/backend_registry.h"

namespace saccade {

/// Everything that files and options can name. A value: main builds it, may add rows, and passes it on.
struct Registry {
  DetectorRegistry detectors;
  ControllerRegistry controllers;
  GateRegistry gates;
  FormatRegistry formats;
  BackendRegistry backends;
};

}  // namespace saccade
