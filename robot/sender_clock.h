#pragma once

#include <array>
#include <cstdint>

namespace saccade {

/// Puts the times of a sender, whose clock started whenever, onto the receiver's clock. The offset between both is
/// that of the message with the least delay of the last 8 to 10 s, so that what the network adds now and then does not
/// shake the times, and clocks that drift apart are followed. What every message is delayed by cannot be seen: times
/// come out later by it. A sender whose clock jumps by more than 1 s starts anew.
class SenderClock {
 public:
  /// When on the receiver's clock the sender's `sent_us` was, from a message that came at `arrival_us` (never goes
  /// back). Never after arrival_us.
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

/// Continues a counter of `bits` bits that wraps.
class StampCounter {
 public:
  /// 1 to 32 bits.
  explicit StampCounter(int bits);
  /// The first stamp of a message in ticks that do not wrap, `elapsed_ticks` after the one before: of all times with
  /// these bits the nearest to what has passed, so that a long silence is no riddle.
  std::int64_t begin(std::uint32_t stamp, std::int64_t elapsed_ticks);
  /// One more stamp of the same message, the nearest to the one before.
  std::int64_t next(std::uint32_t stamp) { return begin(stamp, 0); }

 private:
  std::int64_t range_;
  bool started_ = false;
  std::int64_t last_ = 0;
};

}  // namespace saccade
