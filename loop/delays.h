#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/event.h"
#include "robot/ports.h"

namespace saccade {

/// Events on their way from the camera to the detectors.
class TransportDelay {
 public:
  /// `delay_us` >= 0: from the time stamp to the arrival.
  explicit TransportDelay(std::int64_t delay_us, std::size_t reserved_events);

  /// Appends events, sorted by time and not before earlier ones; returns those that arrive in the tick at t_us. Valid
  /// until the next call.
  [[nodiscard]] std::span<const Event> pass(std::span<const Event> events, std::int64_t t_us);
  [[nodiscard]] std::int64_t delay_us() const { return delay_us_; }

 private:
  std::int64_t delay_us_;
  std::vector<Event> events_;
  std::size_t passed_ = 0;  // of events_, at its front
};

/// Commands on their way to the head.
class CommandDelay {
 public:
  CommandDelay();

  /// A command that reaches the head at ready_us; not before earlier ones.
  void push(const HeadCommand& reference_rad, std::int64_t ready_us);
  /// The newest command that has reached the head by t_us and was not returned before; none if there is none.
  [[nodiscard]] std::optional<HeadCommand> pop(std::int64_t t_us);
  void clear() { count_ = 0; }

 private:
  struct Command {
    HeadCommand reference_rad = HeadCommand::Zero();
    std::int64_t ready_us;
  };
  static constexpr std::size_t capacity = 4096;  // one per tick; both delays are at most 1 s each

  std::vector<Command> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace saccade
