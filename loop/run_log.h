#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "loop/loop.h"
#include "recording/output_file.h"

namespace saccade {

/// The log of a run, `log.txt`: one line, with its time, for every change of state and none for a tick that
/// is like the last one.
///
///     the ball found, found again, lost (since when; whether the head holds or returns to rest), never found
///     targets refused and why, by gate or controller; a burst of them is one line with a count, at its end
///     the head's state not finite (the head holds), and finite again
///     commands refused by the head, and taken again
///
/// Of a run in which nothing drives the gaze only the head's lines.
class RunLog final : public LoopObserver {
 public:
  /// `echo` gets each line too, without its end, as soon as it is written. Throws RunError where the file
  /// cannot be written, as do the others.
  RunLog(const std::filesystem::path& file, std::function<void(const std::string&)> echo);

  void on_tick(const Tick& tick) override;
  /// A line that is not of a tick.
  void note(std::int64_t t_us, const std::string& text) { write(t_us, text); }
  /// Says what is still to be said and gives the file its name.
  void finish();

 private:
  /// Refusals of one kind, none of them more than burst_gap_us after the one before.
  struct Burst {
    std::int64_t count = 0;
    std::int64_t first_us = 0;
    std::int64_t last_us = 0;

    void add(std::int64_t more, std::int64_t t_us);
  };
  static constexpr std::int64_t burst_gap_us = 250'000;
  static constexpr std::size_t refusal_count = 4;

  void write(std::int64_t t_us, const std::string& text);
  void follow_phase(const Tick& tick);
  void follow_refusals(const Tick& tick);
  void follow_head(const Tick& tick);
  void end_burst(std::size_t kind);

  OutputFile file_;
  std::function<void(const std::string&)> echo_;
  std::int64_t now_us_ = 0;
  GazePhase phase_ = GazePhase::none;
  std::array<std::int64_t, refusal_count> rejected_{};  ///< by the gate, of the last tick
  std::array<Burst, refusal_count> bursts_;
  Burst not_finite_;  ///< ticks in which the head's state was not finite, until it is again
  Burst refused_;     ///< commands that the head refused, until it takes one
};

}  // namespace saccade
