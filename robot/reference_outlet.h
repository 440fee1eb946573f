#pragma once

#include <array>
#include <atomic>
#include <optional>

#include "head/head_state.h"
#include "robot/latest_value.h"

namespace saccade {

/// What a thread that sends references to a board has to send: the newest command, or from a halt on the reference of the
/// halt and nothing else until resume(). Without a reference of the halt (no reading of the joints, nothing sent so far)
/// nothing is sent: the joints hold what they have. No side waits for another.
class ReferenceOutlet {
 public:
  using Degrees = std::array<double, gaze_slots>;

  /// Of the thread that commands. Without effect from halt() to resume().
  void command(const Degrees& reference_deg) {
    if (!halted_) command_deg_.write(reference_deg);
  }
  /// Of the thread that halts.
  void halt() {
    has_hold_ = false;
    halted_ = true;
  }
  /// After halt(), from the same thread: where the joints stop.
  void hold_at(const Degrees& reference_deg) {
    hold_deg_.write(reference_deg);
    has_hold_ = true;
  }
  void resume() { halted_ = false; }

  [[nodiscard]] bool halted() const { return halted_; }
  /// The newest command; none before the first.
  [[nodiscard]] std::optional<Degrees> commanded() const {
    return command_deg_.count() < 2 ? std::nullopt : std::optional(command_deg_.read());
  }
  [[nodiscard]] std::optional<Degrees> to_send() const {
    if (!halted_) return commanded();
    return has_hold_ ? std::optional(hold_deg_.read()) : std::nullopt;
  }

 private:
  LatestValue<Degrees> command_deg_;  // the first value is none of a command
  LatestValue<Degrees> hold_deg_;
  std::atomic<bool> halted_ = false;
  std::atomic<bool> has_hold_ = false;
};

}  // namespace saccade
