#pragma once

#include <string>

namespace saccade {

/// While it lives, the operating system is asked to run this thread before all others (SCHED_FIFO) and to keep the
/// program's memory where it is (mlockall). What is not allowed is left as it was.
class RealTime {
 public:
  RealTime();
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;
  ~RealTime();

  /// In words, what came of it.
  [[nodiscard]] const std::string& told() const { return told_; }

 private:
  std::string told_;
};

}  // namespace saccade
