#pragma once

#include <string>

namespace saccade::inline v0_1 {

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

}  // namespace saccade::inline v0_1
