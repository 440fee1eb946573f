#include "robot/replay/replay_robot.h"
#include "tests/recording/temp_folder.h"
#include "tests/robot/port_conformance.h"
#include "tests/robot/scripted_world.h"

namespace saccade {
namespace {

RobotUnderTest fake(FakeRobotScript script) {
  auto robot = std::make_shared<FakeRobot>(std::move(script));
  return {robot, robot.get(), robot.get(), robot.get()};
}

/// Replays a recording of the scripted world from a folder of its own.
struct Playback {
  TempFolder folder;
  std::unique_ptr<ReplayRobot> robot;

  Playback(const char* name, bool with_joints) {
    const FakeRobotScript script = scripted_world();
    const auto writer = create_event_file(folder / name, script.image_size);
    writer->write(script.events);
    writer->commit();
    EventReadOptions options;
    options.image_size = script.image_size;
    robot = std::make_unique<ReplayRobot>(open_event_file(folder / name, options),
                                          with_joints ? std::optional(record_head(script)) : std::nullopt);
  }

  RecordedHead record_head(const FakeRobotScript& script) const {
    FakeRobot head(script);
    head.command(HeadCommand::Constant(0.4));
    TableWriter<JointsRow> joints(folder / "joints.csv");
    for (std::int64_t t_us = script.start_us; t_us <= *script.end_us; t_us += 1000) {
      head.wait_until(t_us);
      HeadState state;
      head.read(state);
      joints.write({state.t_us, state.position_rad});
    }
    joints.commit();
    return {TableReader<JointsRow>(folder / "joints.csv"), script.limits};
  }
};

RobotUnderTest replay(const char* name, bool with_joints) {
  auto playback = std::make_shared<Playback>(name, with_joints);
  ReplayRobot* robot = playback->robot.get();
  return {playback, robot, robot, robot->head()};
}

PortBackend late_fake() {
  FakeRobotScript script = scripted_world();
  script.lateness_us = 5000;
  script.end_us.reset();
  return {"FakeWithLateEvents", [script] { return fake(script); }, true, false, script.lateness_us};
}

INSTANTIATE_TEST_SUITE_P(
    Robot, PortConformance,
    testing::Values(PortBackend{"Fake", [] { return fake(scripted_world()); }, true, true}, late_fake(),
                    PortBackend{"ReplayOfText", [] { return replay("a.csv", false); }, false, true},
                    PortBackend{"ReplayOfAedat2WithJoints", [] { return replay("a.aedat", true); }, false,
                                true}),
    name_of_backend);

}  // namespace
}  // namespace saccade
