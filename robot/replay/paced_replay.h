#pragma once

#include <chrono>
#include <string>

#include "robot/replay/replay_robot.h"
#include "robot/robot.h"

namespace saccade {

/// A recording replayed in real time, as a robot delivers it. If it has joints, its head accepts commands and moves as
/// recorded.
class PacedReplay final : public Robot, public Clock {
 public:
  /// `speed`: seconds of the recording per second of the clock, > 0. `name` appears in check(). Time starts with the
  /// first wait_until. Throws InputError as ReplayRobot does.
  PacedReplay(std::string name, std::unique_ptr<EventReader> events, std::optional<RecordedHead> head,
              double speed);

  Clock& clock() override { return *this; }
  EventSource& events() override { return replay_; }
  HeadPort* head() override { return replay_.head(); }
  ImuPort* imu() override { return replay_.imu(); }
  std::vector<StartUpCheck> check() override;

  /// By the steady clock; events and joints are those of the last wait_until.
  [[nodiscard]] std::int64_t now_us() const override;
  PortStatus wait_until(std::int64_t t_us) override;

 private:
  std::string name_;
  ReplayRobot replay_;
  double speed_;
  std::int64_t start_us_;
  std::optional<std::chrono::steady_clock::time_point> start_;
};

}  // namespace saccade
