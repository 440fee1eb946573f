#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/config.h"
#include "robot/backend_registry.h"
#include "robot/robot.h"

namespace saccade {

/// The backend `external`: a robot in a program of its own, which listens on a socket.
struct ExternalRobotConfig {
  std::string address;                  ///< HOST:PORT, or the path of a Unix socket
  double timeout_s = 2.0;               ///< for the connection and each answer
  std::int64_t queue_events = 100'000;  ///< events received and not read yet; older ones are dropped
};

/// Keys: address, timeout_s, queue_events.
void describe(FieldVisitor& v, ExternalRobotConfig& config);
/// The address, the same for deploy and its guard.
[[nodiscard]] std::string head_name(const ExternalRobotConfig& config);

/// A robot in a program of its own, by the frames of robot_frames.h.
///
/// - Clock: the steady clock of the machine, 0 at construction. Times of the robot are converted by SenderClock.
/// - read_until(), read(), command(), stop() and halt() use memory alone. One thread receives, one sends: the newest
///   reference at once, and a heartbeat every 10 ms as long as ticks come (wait_until), so that the robot's own watchdog
///   stops the head of a deploy that is killed, halted, or hangs.
/// - A closed connection, an unreadable frame, and a robot that takes no bytes for timeout_s: every port is `lost`.
class ExternalRobot final : public Robot {
 public:
  /// Connects and reads the hello. Throws InputError for a configuration out of range and for a robot with another image or
  /// other joints than the file's, RunError if nobody answers.
  ExternalRobot(const ExternalRobotConfig& config, const RobotContext& context);
  ~ExternalRobot() override;

  Clock& clock() override;
  EventSource& events() override;
  HeadPort* head() override;  ///< null for a robot without joints
  ImuPort* imu() override;
  /// Takes up to 1 s for a camera or joints that send nothing.
  std::vector<StartUpCheck> check() override;
  void activate() override;
  void release() override;
  void halt() override;
  std::vector<std::string> news() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The connection of `saccade guard` to such a robot.
class ExternalHeadStopper final : public HeadStopper {
 public:
  /// As ExternalRobot.
  ExternalHeadStopper(const ExternalRobotConfig& config, const RobotContext& context);
  ~ExternalHeadStopper() override;
  [[nodiscard]] bool is_connected() override;
  /// Returns true once the robot reports that its joints follow nobody, at most 50 ms later.
  bool stop() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Adds the row `external`.
void add_external_robots(BackendRegistry& registry);

}  // namespace saccade
