#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/config/registry.h"
#include "apps/config/sections.h"
#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "control/gaze_controller.h"
#include "loop/watchdog.h"
#include "robot/head_limits.h"
#include "robot/yarp/yarp_config.h"

namespace saccade {

/// A robot and what shall be done with it, as the file of `saccade deploy` says.
struct RobotFile {
  std::string name;
  std::string description;
  std::string backend;  ///< yarp or recording

  YarpConfig yarp;

  struct Recording {
    std::string path;    ///< event file or run folder
    double speed = 1.0;  ///< of its time against ours
  } recording;

  MountedCamera calibration;
  HeadLimitsConfig limits;
  NamedDetectors detectors;

  struct Gaze {
    std::string detector = "none";  ///< which of the detectors drives; none: the head is not moved
    GateConfig gate;
    GazeControllerConfig controller;  ///< unless the robot has its own, has_own_controller()
    FollowConfig follow;
  } gaze;

  struct Deploy {
    double tick_ms = 1.0;
    double ramp_in_s = 2.0;
    std::int64_t max_events_per_tick = 2000;
    double shadows_until_ms = 0.5;
    WatchdogConfig watchdog;
  } deploy;

  struct Output {
    std::string events = "aedat4";  ///< a format of any duration, of FormatRegistry::run_choices
  } output;

  /// Targets go to the robot's gaze controller (`yarp.head.control: gaze`).
  [[nodiscard]] bool has_own_controller() const { return backend == "yarp" && yarp.head.control == "gaze"; }
};

/// Keys: those of a robot file.
void describe(FieldVisitor& v, RobotFile& robot);

/// Reads a robot file, `assignments` over it. `calibration` has no defaults: it names a file (`calibration.file`, as
/// read_calibration reads it) or every value of the lens. Paths are relative to the file, from --set relative to the
/// working directory. Throws InputError with everything that is wrong.
[[nodiscard]] RobotFile read_robot_file(const std::filesystem::path& path,
                                        const std::vector<std::string>& assignments,
                                        const Registry& registry);
/// The robot file with every default, as YAML that reads back the same.
[[nodiscard]] std::string resolved_robot_file(const RobotFile& robot);

}  // namespace saccade
