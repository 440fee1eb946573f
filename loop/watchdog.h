#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/config.h"
#include "core/units.h"
#include "head/head_state.h"
#include "robot/ports.h"

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
  joint_off,        ///< a person or a program switched it off
  joint_fault,      ///< its board reports a hardware fault
  joint_taken,      ///< another program set another mode, or the board reports none
  command_refused,  ///< the head rejected a reference
  joint_lags,       ///< it does not follow its reference
  tick_late,
  tick_hangs,   ///< a tick did not end; stopped from another thread
  guard_lost,   ///< the guard ended, or hangs
  guard_stops,  ///< the guard stopped the head
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
  double joint_lag_deg = 6.0;   ///< a joint does not follow if it is farther than this from its reference,
  double joint_lag_ms = 500.0;  ///< or rests while that moves (FollowWatch), for longer than this
  double hang_ms = 35.0;        ///< without a tick, another thread and the guard stop the head
  double safe_within_ms = 100.0;
};

/// Keys: camera_silent_ms, joints_stale_ms, tick_late_ms, joint_outside_deg, joint_lag_deg, joint_lag_ms, hang_ms,
/// safe_within_ms.
void describe(FieldVisitor& v, WatchdogConfig& config);

/// To what tick_late_ms and hang_ms may both be raised within safe_within_ms, ms.
[[nodiscard]] double longest_halt_ms(const WatchdogConfig& config);

/// State of the robot at the start of a tick. Times in us of the robot's clock.
struct TickFacts {
  std::int64_t due_us = 0;                                ///< when the tick was due
  std::int64_t now_us = 0;                                ///< when it began
  std::int64_t heard_us = 0;                              ///< EventSource::heard_us
  std::optional<HeadState> head = std::nullopt;           ///< newest reading; none without a head
  std::optional<HeadDrives> drives = std::nullopt;        ///< none where the loop sends no references
  std::optional<std::int64_t> refused_us = std::nullopt;  ///< when the head rejected the newest reference
  /// Since when a joint does not follow its reference, and which joint; see FollowWatch.
  std::optional<std::int64_t> lags_since_us = std::nullopt;
  int lagging = neck_pitch;  ///< its slot
};

/// Measures since when each joint does not follow its reference: it is farther than lag_deg from it, or it rests within
/// 0.2 deg while its reference has moved over more than 3 deg, as that of a stuck joint does which swings about it. A
/// reading is compared with the reference of its own time, at most 128 ticks ago: with a newer one, a joint that moves fast
/// would lag by the age of its reading.
class FollowWatch {
 public:
  explicit FollowWatch(double lag_deg) : lag_rad_(lag_deg * rad_per_deg) {}
  /// The reference sent in the tick at t_us, and the newest positions in that tick with their time, rad.
  void update(std::int64_t t_us, const HeadJointVector& reference_rad, std::int64_t read_us,
              const HeadJointVector& position_rad);
  void clear() {
    joints_.fill({});
    sent_ = 0;
  }
  /// Adds the joint that has not followed for the longest time to the facts of a tick.
  void add_to(TickFacts& facts) const;

 private:
  struct Joint {
    std::optional<std::int64_t> far_since_us, stuck_since_us;
    /// Where it rests, and the smallest and largest reference since then; none before the first update.
    std::optional<double> rest_rad;
    double least_rad = 0.0, largest_rad = 0.0;
  };
  struct Sent {
    std::int64_t t_us = 0;
    HeadJointVector reference_rad = HeadJointVector::Zero();
  };
  /// The reference that was sent last before a reading, or else the oldest one.
  [[nodiscard]] const HeadJointVector& reference_at(std::int64_t read_us) const;

  double lag_rad_;
  std::array<Joint, gaze_slots> joints_{};
  std::array<Sent, 128> history_{};
  std::size_t sent_ = 0;  // references so far
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
