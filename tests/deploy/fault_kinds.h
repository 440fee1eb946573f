#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/deploy/deploy_session.h"
#include "core/random.h"
#include "robot/fake/fake_robot.h"

namespace saccade {

/// The faults that the campaign draws.
enum class FaultKind {
  camera_silent,
  joints_frozen,
  encoder_not_a_number,
  joint_outside,
  joint_off,
  joint_fault,
  joint_taken,
  command_refused,
  joint_stuck,
  tick_late,
  connection_lost,
  guard_lost,
  guard_stops,
  operator_stops,
  operator_quits,
  broken_camera_messages,
  broken_joint_messages,
  robot_halted,
  deploy_killed,
  deploy_halted,
  guard_killed,
  operator_insists,
  operator_hurries,
  disk_full,
  disk_slow,
  disk_fails,
  count
};

[[nodiscard]] const char* name_of(FaultKind kind);
/// The causes that the log may name for a fault that comes alone; empty: no stop by deploy itself is right.
[[nodiscard]] std::vector<StopCause> right_causes(FaultKind kind);
[[nodiscard]] constexpr bool is_of_disk(FaultKind kind) { return kind >= FaultKind::disk_full; }

/// The faults of a trial. Times in us of the robot's clock.
struct Faults {
  FakeRobotScript script;
  std::optional<std::pair<StopCause, std::int64_t>> demand;
  std::optional<std::int64_t> stop_us, quit_us;
  std::optional<std::int64_t> guard_killed_us;
  std::optional<std::int64_t> killed_us;                           ///< SIGKILL of deploy
  std::optional<std::pair<std::int64_t, std::int64_t>> halted_us;  ///< deploy, from SIGSTOP to SIGCONT
  bool insists = false;                    ///< the operator asks for activation every 20 ms from the stop on
  std::optional<std::int64_t> hurries_us;  ///< until then in every tick, and then to stop
  std::optional<FaultKind> disk;
  std::vector<std::pair<FaultKind, std::int64_t>> list;

  [[nodiscard]] bool has(FaultKind kind) const;
  /// Whether deploy executes nothing at that time.
  [[nodiscard]] bool is_dead(std::int64_t t_us) const;
  /// "camera silent at 812345 us, ..."
  [[nodiscard]] std::string text() const;
};

/// One to three faults of a trial.
[[nodiscard]] Faults make_faults(const RandomStream& random, std::uint64_t trial);

}  // namespace saccade
