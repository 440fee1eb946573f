#pragma once

#include <cstdint>
#include <vector>

#include "head/head_state.h"

namespace saccade {

/// The states of the head in the last ticks, to find the one at which old events were made.
class SeenHeads {
 public:
  SeenHeads() : ring_(capacity) {}

  void push(const HeadState& state, std::int64_t t_us) { ring_[count_++ % capacity] = {t_us, state}; }
  /// The newest state of a tick at or before t_us, or the oldest known one. At least one was pushed.
  [[nodiscard]] const HeadState& at(std::int64_t t_us) const {
    const std::size_t known = count_ < capacity ? count_ : capacity;
    std::size_t back = 1;
    while (back < known && ring_[(count_ - back) % capacity].t_us > t_us) ++back;
    return ring_[(count_ - back) % capacity].state;
  }

 private:
  static constexpr std::size_t capacity = 512;  // one per tick
  struct Seen {
    std::int64_t t_us = 0;
    HeadState state;
  };
  std::vector<Seen> ring_;
  std::size_t count_ = 0;
};

}  // namespace saccade
