#include "apps/deploy/robot_backends.h"

#include <array>
#include <filesystem>
#include <string>

#include "apps/config/robot_file.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "robot/replay/paced_replay.h"
#ifdef SACCADE_YARP
#include "robot/yarp/yarp_robot.h"
#endif

namespace saccade {
namespace {

std::unique_ptr<Robot> open_recording(const RobotFile& file) {
  const std::filesystem::path path = file.recording.path;
  std::filesystem::path events = path;
  std::optional<RecordedHead> head;
  if (std::filesystem::is_directory(path)) {
    events = path / read_metrics(path / "metrics.json").events_file;
    const std::filesystem::path joints = path / "joints.csv";
    if (std::filesystem::exists(joints))
      head.emplace(RecordedHead{TableReader<JointsRow>(joints), joint_limits(file.limits)});
  }
  EventReadOptions read;
  read.camera = std::uint8_t{0};
  read.image_size = file.calibration.camera.size;
  return std::make_unique<PacedReplay>(path.filename().string(), open_event_file(events, read),
                                       std::move(head), file.recording.speed);
}

#ifdef SACCADE_YARP
std::unique_ptr<Robot> open_yarp(const RobotFile& file) {
  return std::make_unique<YarpRobot>(file.yarp, joint_limits(file.limits));
}
#else
std::unique_ptr<Robot> open_yarp(const RobotFile& file) {
  throw InputError("backend", file.backend,
                   "recording: this build has no YARP; docs/robot.md describes how to install it");
}
#endif

constexpr std::array<RobotBackend, 2> backends_of_this_build = {{
    {"recording", "an event file or run folder, replayed in real time", open_recording},
    {"yarp", "an iCub on a YARP network", open_yarp},
}};

}  // namespace

std::span<const RobotBackend> robot_backends() { return backends_of_this_build; }

std::unique_ptr<Robot> open_robot(const RobotFile& file, std::span<const RobotBackend> backends) {
  std::string names;
  for (const RobotBackend& backend : backends) {
    if (backend.name == file.backend) return backend.open(file);
    names += (names.empty() ? "" : ", ") + std::string(backend.name);
  }
  throw InputError("backend", file.backend, "one of " + names);
}

}  // namespace saccade
