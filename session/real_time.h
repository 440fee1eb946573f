#pragma once

#include <cstddef>
#include <string>

namespace saccade {

/// Stack of each thread that starts after use_small_stacks(), bytes.
inline constexpr std::size_t small_stack_bytes = 1U << 20U;

/// Gives threads that start from now on stacks of small_stack_bytes, where the default is 8 MiB: locked memory takes whole
/// stacks, whatever a thread uses of them. For the whole program; a system whose default is smaller keeps it.
void use_small_stacks();

/// Priorities of SCHED_FIFO: below the drivers of the hardware, and deploy above a robot that is simulated beside it.
inline constexpr int deploy_priority = 50;
inline constexpr int serve_ports_priority =
    41;  ///< above the simulation, so that readings come while an image is drawn
inline constexpr int serve_priority = 40;

/// Where the examples of messages permit real-time priority and locked memory.
inline constexpr const char* limits_file = "/etc/security/limits.d/saccade.conf";

enum class LockMemory { no, yes };

/// What to set so that real-time priority is granted. Where the system groups processes by session (autogroup), it adds that
/// nice values have no effect between sessions.
[[nodiscard]] std::string how_to_permit_real_time();

/// Whether the processor says that it is that of a virtual machine (x86 only; false elsewhere).
[[nodiscard]] bool is_virtual_machine();

/// Requests real-time priority for this thread (SCHED_FIFO) and, with `lock`, locks the program's memory (mlockall) for its
/// lifetime, as far as the operating system permits. Threads that this one starts meanwhile have the same priority.
class RealTime {
 public:
  explicit RealTime(int priority = deploy_priority, LockMemory lock = LockMemory::yes);
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;
  ~RealTime();

  /// What the operating system granted, in words.
  [[nodiscard]] const std::string& summary() const { return summary_; }
  /// Whether it granted the priority.
  [[nodiscard]] bool granted() const { return granted_; }

 private:
  bool granted_ = false;
  LockMemory lock_;
  std::string summary_;
};

}  // namespace saccade
