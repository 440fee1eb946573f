#pragma once

#include <string>

#include "core/config.h"
#include "robot/backend_registry.h"

namespace saccade {

/// The backend `recording`: a recording that replaces the robot.
struct RecordingBackendConfig {
  std::string path;    ///< event file, or run folder with joints
  double speed = 1.0;  ///< seconds of the recording per second
};

/// Keys: path, speed.
void describe(FieldVisitor& v, RecordingBackendConfig& config);

/// The backends that saccade ships: recording, yarp. Without YARP in this build, yarp can be configured but not opened.
[[nodiscard]] BackendRegistry built_in_backends();

}  // namespace saccade
