#pragma once

#include <memory>
#include <span>
#include <string_view>

namespace saccade {

struct RobotFile;
class Robot;

/// A kind of robot that `backend` in a robot file can name.
struct RobotBackend {
  std::string_view name;
  std::string_view meaning;
  /// Connects to the robot of the file. Throws InputError if this build has no such backend or the recording cannot be
  /// read, RunError if the robot does not answer.
  std::unique_ptr<Robot> (*open)(const RobotFile& file);
};

/// The backends of this build: recording, yarp.
[[nodiscard]] std::span<const RobotBackend> robot_backends();

/// Connects to the robot that the file names. Throws as RobotBackend::open does, InputError for an unknown backend.
[[nodiscard]] std::unique_ptr<Robot> open_robot(const RobotFile& file,
                                                std::span<const RobotBackend> backends = robot_backends());

}  // namespace saccade
