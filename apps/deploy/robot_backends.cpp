#include "apps/deploy/robot_backends.h"

#include <filesystem>

#include "apps/deploy/practice_robot.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "recording/event_file.h"
#include "robot/replay/paced_replay.h"
#include "robot/yarp/yarp_config.h"
#include "session/replay_source.h"
#ifdef SACCADE_YARP
#include "robot/yarp/yarp_robot.h"
#endif

namespace saccade {
namespace {

std::unique_ptr<Robot> open_recording(const RecordingBackendConfig& config, const RobotContext& context) {
  const std::filesystem::path path = config.path;
  std::filesystem::path events = path;
  std::optional<RecordedHead> head;
  if (std::filesystem::is_directory(path)) {
    events = path / read_metrics(path / "metrics.json").events_file;
    head = recorded_head(path);
    if (head) head->limits = context.limits;
  }
  EventReadOptions read;
  read.camera = std::uint8_t{0};
  read.image_size = context.image_size;
  return std::make_unique<PacedReplay>(path.filename().string(),
                                       open_event_file(context.formats, events, read), std::move(head),
                                       config.speed);
}

#ifdef SACCADE_YARP
std::unique_ptr<Robot> open_yarp(const YarpConfig& config, const RobotContext& context) {
  return std::make_unique<YarpRobot>(config, context.limits);
}

std::unique_ptr<HeadStopper> open_yarp_stopper(const YarpConfig& config, const RobotContext& context) {
  return std::make_unique<YarpHeadStopper>(config, context.limits);
}
#else
[[noreturn]] void refuse_yarp() {
  throw InputError(
      "backend", "yarp",
      "recording or practice: this build has no YARP; docs/robot.md describes how to install it");
}

std::unique_ptr<Robot> open_yarp(const YarpConfig&, const RobotContext&) { refuse_yarp(); }
std::unique_ptr<HeadStopper> open_yarp_stopper(const YarpConfig&, const RobotContext&) { refuse_yarp(); }
#endif

std::unique_ptr<Robot> open_practice(const PracticeConfig& config, const RobotContext& context) {
  return std::make_unique<PracticeRobot>(config, context);
}

std::unique_ptr<HeadStopper> open_practice_stopper(const PracticeConfig& config, const RobotContext&) {
  return std::make_unique<PracticeStopper>(config);
}

}  // namespace

void describe(FieldVisitor& v, RecordingBackendConfig& config) {
  v.path("path", config.path, "event file, or run folder with joints");
  v.real("speed", config.speed, {0.01, 100.0}, "seconds of the recording per second");
}

BackendRegistry built_in_backends() {
  BackendRegistry registry;
  RobotBackend recording = backend_row("recording", "an event file or run folder, replayed in real time",
                                       RecordingBackendConfig{}, open_recording);
  recording.required = {"path"};
  registry.add(std::move(recording));
  RobotBackend yarp = backend_row("yarp", "an iCub on a YARP network", YarpConfig{}, open_yarp);
  yarp.open_stopper = for_erased_config<YarpConfig>(open_yarp_stopper);
  registry.add(std::move(yarp));
  RobotBackend practice =
      backend_row("practice", "a head in shared memory that sees a ball, to practise with", PracticeConfig{},
                  open_practice);
  practice.open_stopper = for_erased_config<PracticeConfig>(open_practice_stopper);
  registry.add(std::move(practice));
  return registry;
}

}  // namespace saccade
