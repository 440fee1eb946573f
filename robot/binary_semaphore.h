#pragma once

#include <semaphore.h>
#include <time.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>

namespace saccade {

/// Wakes one waiting thread. Requests before it wakes count as one, so a waiter is never behind; request() neither locks
/// nor waits. (std::counting_semaphore of libstdc++ 12 yields the processor in each try_acquire: on a loaded machine a
/// thread that takes its requests one by one is slower than the ticks that make them.)
class BinarySemaphore {
 public:
  BinarySemaphore() { sem_init(&semaphore_, 0, 0); }
  ~BinarySemaphore() { sem_destroy(&semaphore_); }
  BinarySemaphore(const BinarySemaphore&) = delete;
  BinarySemaphore& operator=(const BinarySemaphore&) = delete;

  /// From any thread.
  void request() {
    if (!wanted_.exchange(true, std::memory_order_acq_rel)) sem_post(&semaphore_);
  }

  /// Returns after a request.
  void wait() {
    while (sem_wait(&semaphore_) != 0) {  // interrupted by a signal
    }
    wanted_.exchange(false, std::memory_order_acq_rel);
  }

  /// Whether a request came within the time.
  [[nodiscard]] bool wait_for(std::chrono::nanoseconds time) {
    timespec until{};
    clock_gettime(CLOCK_MONOTONIC, &until);
    const std::int64_t ns = until.tv_nsec + time.count();
    until.tv_sec += ns / 1'000'000'000;
    until.tv_nsec = ns % 1'000'000'000;
    while (sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &until) != 0) {
      if (errno != EINTR) return false;
    }
    wanted_.exchange(false, std::memory_order_acq_rel);
    return true;
  }

 private:
  sem_t semaphore_;
  std::atomic<bool> wanted_ = false;
};

}  // namespace saccade
