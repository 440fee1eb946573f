#pragma once

#include <cstddef>
#include <string>

namespace saccade {

/// Stack of each thread that starts after use_small_stacks(), bytes.
inline constexpr std::size_t small_stack_bytes = 1U << 20U;

/// Gives threads that start from now on stacks of small_stack_bytes, where the default is 8 MiB: locked memory takes whole
/// stacks, whatever a thread uses of them. For the whole program; a system whose default is smaller keeps it.
void use_small_stacks();

/// Requests real-time priority for this thread (SCHED_FIFO) and locks the program's memory (mlockall) for its lifetime,
/// as far as the operating system permits.
class RealTime {
 public:
  RealTime();
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;
  ~RealTime();

  /// What the operating system granted, in words.
  [[nodiscard]] const std::string& summary() const { return summary_; }

 private:
  std::string summary_;
};

}  // namespace saccade
