#pragma once

#include <array>
#include <cstdint>

namespace saccade {

/// Converts time stamps from the clock of a sender to the clock of the receiver. The offset is that of the message with
/// the least delay of the last 8 to 10 s, so that variations of the network delay have no effect and clock drift is
/// compensated. The constant part of the delay is not observable: converted times are late by it. A jump of the sender's
/// clock by more than 1 s resets the offset.
class SenderClock {
 public:
  /// The time `sent_us` of the sender on the clock of the receiver, for a message that arrived at `arrival_us` (never
  /// decreases). Not after arrival_us.
  std::int64_t to_local(std::int64_t sent_us, std::int64_t arrival_us);
  void restart() { started_ = false; }

 private:
  static constexpr std::int64_t bucket_us = 2'000'000;
  static constexpr std::int64_t jump_us = 1'000'000;

  [[nodiscard]] std::int64_t least_delay_us() const;

  bool started_ = false;
  std::int64_t bucket_ = 0;                     // number of the newest
  std::array<std::int64_t, 5> delays_us_ = {};  // the least of each bucket, by its number modulo their count
};

/// Unwraps a counter of `bits` bits.
class StampCounter {
 public:
  /// 1 to 32 bits.
  explicit StampCounter(int bits);
  /// The first stamp of a message, unwrapped, about `elapsed_ticks` after the one before: of all times with these bits the
  /// nearest one, so that time stamps are unwrapped correctly after a long pause.
  std::int64_t begin(std::uint32_t stamp, std::int64_t elapsed_ticks);
  /// The next stamp of the same message, unwrapped to the time nearest to the one before.
  std::int64_t next(std::uint32_t stamp) { return begin(stamp, 0); }

 private:
  std::int64_t range_;
  bool started_ = false;
  std::int64_t last_ = 0;
};

}  // namespace saccade
