#pragma once

#include <chrono>
#include <string>

#include "robot/replay/replay_robot.h"
#include "robot/robot.h"

namespace saccade {

/// A recording that passes in real time, as a robot's world does. Its head, where it has joints, takes commands and
/// moves as it did.
class PacedReplay final : public Robot, public Clock {
 public:
  /// `speed` seconds of the recording pass in one of ours, > 0. `name` is told in check(). Time starts to pass with the
  /// first wait_until.
  /// Throws InputError as ReplayRobot does.
  PacedReplay(std::string name, std::unique_ptr<EventReader> events, std::optional<RecordedHead> head,
              double speed);

  Clock& clock() override { return *this; }
  EventSource& events() override { return replay_; }
  HeadPort* head() override { return replay_.head(); }
  GazePort* gaze() override { return nullptr; }
  std::vector<StartUpCheck> check() override;
  void activate() override {}
  void release() override {}

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
