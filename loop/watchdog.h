#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/config.h"
#include "head/head_state.h"

namespace saccade {

/// Why a moving head was stopped.
enum class StopCause {
  operator_stop,
  interrupted,  ///< by a signal
  ended,        ///< end of the recording, or of the run's duration
  lost,         ///< the connection to a part of the robot, as its ports report
  camera_silent,
  joints_stale,
  joints_not_finite,
  joint_outside,
  tick_late,
};
/// Whether a cause is a fault, not a request.
[[nodiscard]] constexpr bool is_fault(StopCause cause) { return cause >= StopCause::lost; }

/// How long a fault may last before the head is stopped. Each time runs from the fact (the last packet, the last
/// reading, the instant a tick was due) to the stop command. The watchdog runs once per tick: if ticks are late by
/// tick_late_ms at most, every stop comes within safe_within_ms of its fact.
struct WatchdogConfig {
  double camera_silent_ms = 60.0;
  double joints_stale_ms = 60.0;
  double tick_late_ms = 20.0;
  double joint_outside_deg = 1.0;
  double safe_within_ms = 100.0;
};

/// Keys: camera_silent_ms, joints_stale_ms, tick_late_ms, joint_outside_deg, safe_within_ms.
void describe(FieldVisitor& v, WatchdogConfig& config);

/// State of the robot at the start of a tick. Times in us of the robot's clock.
struct TickFacts {
  std::int64_t due_us = 0;                       ///< when the tick was due
  std::int64_t now_us = 0;                       ///< when it began
  std::int64_t heard_us = 0;                     ///< EventSource::heard_us
  std::optional<HeadState> head = std::nullopt;  ///< newest reading; none without a head
};

/// A stop: its cause, time and extent.
struct Fault {
  StopCause cause = StopCause::operator_stop;
  std::int64_t since_us = 0;   ///< time of the fact
  std::string_view part = {};  ///< joint, or part of the robot
  double amount = 0.0;         ///< ms, or deg outside the limits

  /// "no packet from the camera for 61.0 ms", "neck_yaw 1.2 deg outside its limits".
  [[nodiscard]] std::string description() const;
};

/// Checks a robot at the start of each tick. Keeps no state: the result depends on the facts alone.
class Watchdog {
 public:
  /// `limits`: of the head. Throws InputError.
  explicit Watchdog(const WatchdogConfig& config, const JointLimits& limits = {});
  /// The first fault in the order of StopCause from camera_silent on; none if all is well.
  [[nodiscard]] std::optional<Fault> check(const TickFacts& facts) const;

 private:
  WatchdogConfig config_;
  JointLimits limits_;
};

}  // namespace saccade
