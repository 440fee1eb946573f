#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace saccade {

/// A queue of fixed size from one thread to one other. Neither side waits, locks or allocates.
template <class T>
class SpscRing {
 public:
  /// `capacity` slots, each a copy of `slot`, whose memory is used again and again.
  explicit SpscRing(std::size_t capacity, const T& slot = {}) : slots_(capacity + 1, slot) {}

  /// Sender: the next free slot to fill; null when all are taken.
  [[nodiscard]] T* claim() {
    const std::size_t at = end_.load(std::memory_order_relaxed);
    return next(at) == begin_.load(std::memory_order_acquire) ? nullptr : &slots_[at];
  }
  /// Sender: what claim() gave is full and the receiver's.
  void publish() { end_.store(next(end_.load(std::memory_order_relaxed)), std::memory_order_release); }
  /// Receiver: the oldest full slot; null when there is none.
  [[nodiscard]] T* front() {
    const std::size_t at = begin_.load(std::memory_order_relaxed);
    return at == end_.load(std::memory_order_acquire) ? nullptr : &slots_[at];
  }
  /// Receiver: what front() gave is free again.
  void pop() { begin_.store(next(begin_.load(std::memory_order_relaxed)), std::memory_order_release); }
  /// Sender: how many slots are free, at least.
  [[nodiscard]] std::size_t room() const {
    const std::size_t begin = begin_.load(std::memory_order_acquire);
    const std::size_t end = end_.load(std::memory_order_relaxed);
    return (begin + slots_.size() - end - 1) % slots_.size();
  }

 private:
  [[nodiscard]] std::size_t next(std::size_t at) const { return at + 1 == slots_.size() ? 0 : at + 1; }

  std::vector<T> slots_;
  alignas(64) std::atomic<std::size_t> begin_ = 0;  // the receiver moves it
  alignas(64) std::atomic<std::size_t> end_ = 0;    // the sender moves it
};

}  // namespace saccade
