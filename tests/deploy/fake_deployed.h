#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "robot/fake/fake_robot.h"
#include "robot/robot.h"
#include "tests/control/genova02.h"

namespace saccade {

/// A camera of 128 x 128 that sends 100 events of random pixels per millisecond for 2 s.
inline FakeRobotScript script_with_busy_camera() {
  FakeRobotScript script;
  script.limits = genova02_limits();
  const RandomStream random(5, "events");
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    script.events.push_back(
        {static_cast<std::int64_t>(i * 10), static_cast<std::uint16_t>(random.bits(0, i) % 128),
         static_cast<std::uint16_t>(random.bits(1, i) % 128), random.bits(2, i) % 2 == 0, 0});
  }
  return script;
}

/// A fake head as a robot: refuses commands before activate() and after release(). With `with_gaze` it has a gaze
/// controller of its own.
class FakeDeployed final : public Robot, private HeadPort, private GazePort {
 public:
  FakeDeployed(FakeRobotScript script, bool with_gaze) : world(std::move(script)), with_gaze_(with_gaze) {}

  Clock& clock() override { return world; }
  EventSource& events() override { return world; }
  HeadPort* head() override { return this; }
  GazePort* gaze() override { return with_gaze_ ? this : nullptr; }
  std::vector<StartUpCheck> check() override { return {}; }
  void activate() override {
    if (refuse_activation) throw RunError("neck_yaw is in HW_FAULT");
    is_active = true;
    held = false;
    world.wait_until(world.now_us() + activation_us);
  }
  void release() override {
    is_active = false;
    ++released;
  }

  /// The guard takes the head from deploy: the joints hold, and what deploy still sends is rejected until activate().
  void hold() {
    if (first_stop_us == 0) first_stop_us = world.now_us();
    held = true;
    (void)world.stop();
  }

  FakeRobot world;
  bool held = false;
  int rejected_while_held = 0;
  bool refuse_activation = false;
  bool is_active = false;
  std::int64_t activation_us = 0;
  int released = 0;
  int stops = 0;
  std::int64_t first_stop_us = 0;
  int commands = 0;
  std::int64_t last_command_us = 0;
  int commands_while_not_active = 0;
  std::vector<std::pair<std::int64_t, Eigen::Vector3d>> targets;

 private:
  [[nodiscard]] JointLimits limits() const override { return world.limits(); }
  [[nodiscard]] HeadDrives drives() const override { return world.drives(); }
  PortStatus read(HeadState& state) override { return world.read(state); }
  CommandResult command(const HeadCommand& reference_rad) override {
    if (held) {
      ++rejected_while_held;
      return {PortStatus::ok, true};
    }
    ++commands;
    last_command_us = world.now_us();
    commands_while_not_active += is_active ? 0 : 1;
    return world.command(reference_rad);
  }
  PortStatus stop() override {
    ++stops;
    if (first_stop_us == 0) first_stop_us = world.now_us();
    return world.stop();
  }
  PortStatus look_at(const Eigen::Vector3d& target_m) override {
    if (held) return PortStatus::ok;
    commands_while_not_active += is_active ? 0 : 1;
    targets.emplace_back(world.now_us(), target_m);
    return PortStatus::ok;
  }

  bool with_gaze_;
};

}  // namespace saccade
