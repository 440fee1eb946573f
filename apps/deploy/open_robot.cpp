#include "apps/deploy/open_robot.h"

#include <filesystem>

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

}  // namespace

std::unique_ptr<Robot> open_robot(const RobotFile& file) {
  if (file.backend == "recording") return open_recording(file);
#ifdef SACCADE_YARP
  return std::make_unique<YarpRobot>(file.yarp, joint_limits(file.limits));
#else
  throw InputError("backend", file.backend,
                   "recording: this build has no YARP, docs/robot.md tells how to get it");
#endif
}

}  // namespace saccade
