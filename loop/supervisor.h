#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/config.h"
#include "head/head_state.h"

namespace saccade {

/// Where a robot is on its way to being moved:
///
///     unconfigured --every check passed--> ready --operator--> active --operator or a fault--> stopped
///                                                                 ^----------operator------------'
///
/// Only `active` moves the head. `stopped` is the safe state: the head was told to stop and given back, nothing is
/// sent to it, and it stays so until the operator activates again.
enum class DeployState { unconfigured, ready, active, stopped };
[[nodiscard]] std::string_view name_of(DeployState state);

enum class StopCause {
  operator_stop,  ///< the key
  interrupted,    ///< a signal
  ended,          ///< the recording is over, or the time that the run was given
  lost,           ///< the connection to a part of the robot; the ports say so
  camera_silent,
  joints_stale,
  joints_not_finite,
  joint_outside,
  tick_late,
};
/// Of the ones above, those that nobody asked for.
[[nodiscard]] constexpr bool is_fault(StopCause cause) { return cause >= StopCause::lost; }

/// How long something may be amiss before the head is stopped. Each time runs from the fact (the last packet, the last
/// reading, the instant a tick was due) to the stop command, and ends at the first tick after it: with a tick that is
/// late by tick_late_ms at most, every stop comes within safe_within_ms of its fact.
struct WatchdogConfig {
  double camera_silent_ms = 60.0;
  double joints_stale_ms = 60.0;
  double tick_late_ms = 20.0;
  double joint_outside_deg = 1.0;
  double safe_within_ms = 100.0;
};

/// Keys: camera_silent_ms, joints_stale_ms, tick_late_ms, joint_outside_deg, safe_within_ms.
void describe(FieldVisitor& v, WatchdogConfig& config);

/// What is known at the start of a tick. Times in the robot's clock.
struct TickFacts {
  std::int64_t due_us = 0;    ///< when the tick should have begun
  std::int64_t now_us = 0;    ///< when it did
  std::int64_t heard_us = 0;  ///< EventSource::heard_us
  std::optional<HeadState> head = std::nullopt;
};

/// Something that stops a head that is moved.
struct Fault {
  StopCause cause = StopCause::operator_stop;
  std::int64_t since_us = 0;   ///< of the fact
  std::string_view part = {};  ///< which joint, or which part of the robot
  double amount = 0.0;         ///< by how much: ms, or deg outside the limits

  /// "no packet from the camera for 61.0 ms", "neck_yaw 1.2 deg outside its limits".
  [[nodiscard]] std::string in_words() const;
};

/// The first thing that is wrong, in the order of StopCause, on a robot whose connections stand. Keeps nothing, waits for nothing: what it says follows
/// from the facts alone.
class Watchdog {
 public:
  /// `limits` of the head; of no head there is nothing to watch. Throws InputError.
  explicit Watchdog(const WatchdogConfig& config, const JointLimits& limits = {});
  [[nodiscard]] std::optional<Fault> look(const TickFacts& facts) const;

 private:
  WatchdogConfig config_;
  JointLimits limits_;
};

}  // namespace saccade
