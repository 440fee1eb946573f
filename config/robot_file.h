#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/registry.h"
#include "config/sections.h"
#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "control/gaze_controller.h"
#include "head/head_config.h"
#include "head/icub_cameras.h"
#include "loop/watchdog.h"
#include "robot/head_limits.h"

namespace saccade {

/// Whether deploy needs `saccade guard` to activate the head.
enum class GuardUse {
  required,  ///< no activation without it; its loss stops the head
  optional,  ///< used if it is there
  none,      ///< ignored
};
constexpr auto words_of(GuardUse) {
  return std::to_array<Word<GuardUse>>(
      {{GuardUse::required, "required"}, {GuardUse::optional, "optional"}, {GuardUse::none, "none"}});
}

/// The file of `saccade deploy`: a robot, the detectors and the gaze on it, timing and output.
struct RobotFile {
  std::string name;
  std::string description;
  RobotBackendConfig robot;
  MountedCamera calibration{icub_left_2016, {}};
  HeadConfig head;
  HeadLimitsConfig limits;
  NamedDetectors detectors;

  struct Gaze {
    std::string detector =
        "none";  ///< name of the detector that drives the head; none: the head is not moved
    GateConfig gate;
    GazeControllerConfig controller;  ///< unless the robot has its own, robot.has_gaze_controller()
    FollowConfig follow;
  } gaze;

  struct Deploy {
    double tick_ms = 1.0;
    double ramp_in_s = 2.0;
    double activate_within_s = 10.0;
    double edge_check_s = 0.0;
    GuardUse guard = GuardUse::optional;
    std::int64_t max_events_per_tick = 2000;
    double shadows_until_ms = 0.5;
    WatchdogConfig watchdog;
  } deploy;

  struct Output {
    std::string events = "aedat4";  ///< a format of any duration, of FormatRegistry::run_choices
    std::int64_t rotate_mb = 2000;
    double rotate_s = 3600.0;
    std::int64_t least_free_mb = 500;
    FormatRegistry formats;  ///< of the program
  } output;
};

/// A robot file without detectors that can name what the registry holds; everything else has its default.
[[nodiscard]] RobotFile empty_robot_file(const Registry& registry);
/// What opens the robot besides the keys of its backend.
[[nodiscard]] RobotContext robot_context(const RobotFile& file);

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
