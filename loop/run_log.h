#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "loop/loop.h"

namespace saccade {

/// Messages of a run for people: one for every change of state, none for a tick that changes nothing.
///
///     ball found, found again, lost (and whether the head holds or returns to rest), never found
///     targets rejected by gate or controller, with the reason; a burst of them is one message with a count, at its end
///     head state not finite (the head holds), and finite again
///     the head oscillates, and the factor by which the controller's time constants have grown
///     commands rejected by the head, and accepted again
///
/// Without a driving detector only the messages about the head.
class RunLog final : public LoopObserver {
 public:
  /// `sink` receives each message, without line end, with its time; it is called inside on_tick and finish.
  using Sink = std::function<void(std::int64_t t_us, const std::string& text)>;

  explicit RunLog(Sink sink);

  void on_tick(const Tick& tick) override;
  /// Sends the messages that are still open at the end of a run.
  void finish();

 private:
  /// Rejections of one kind, at most burst_gap_us apart.
  struct Burst {
    std::int64_t count = 0;
    std::int64_t first_us = 0;
    std::int64_t last_us = 0;

    void add(std::int64_t more, std::int64_t t_us);
  };
  static constexpr std::int64_t burst_gap_us = 250'000;
  static constexpr std::size_t rejection_count = 6;

  void log_phase(const Tick& tick);
  void log_rejections(const Tick& tick);
  void log_head(const Tick& tick);
  void log_hunting(const Tick& tick);
  void end_burst(std::size_t kind);

  Sink sink_;
  std::int64_t now_us_ = 0;
  GazePhase phase_ = GazePhase::none;
  bool was_found_ = false;                                ///< the ball, at least once
  std::array<std::int64_t, rejection_count> rejected_{};  ///< by the gate, up to the last tick
  std::array<Burst, rejection_count> bursts_;
  Burst not_finite_;         ///< ticks with a head state that is not finite, until it is finite again
  Burst rejected_commands_;  ///< until the head accepts one
};

}  // namespace saccade
