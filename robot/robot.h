#pragma once

#include <string>
#include <vector>

#include "robot/ports.h"

namespace saccade {

/// One thing that was looked at before motors move.
struct StartUpCheck {
  std::string what;  ///< "event port /zynqGrabber/AE:o"
  bool passed = false;
  std::string found;  ///< what is there, and what was expected where it did not pass
};

/// A robot that deploy mode works with: its ports, and the steps from its being there to its being moved. Time in it
/// passes by itself: Clock::wait_until waits.
///
///     connected --check()--> activate() --> ports move the head --> release()
///
/// Until activate(), and after release(), commands and targets are refused; events and joints are read throughout.
class Robot {
 public:
  virtual ~Robot() = default;

  virtual Clock& clock() = 0;
  virtual EventSource& events() = 0;
  virtual HeadPort* head() = 0;  ///< null where there are no joints (a bare recording)
  virtual GazePort* gaze() = 0;  ///< null where the head gets references; else `head` is only read
  /// Looks at everything that has to be right before motors move, and lists it all. Moves nothing.
  virtual std::vector<StartUpCheck> check() = 0;
  /// Takes the joints over. Throws RunError where the robot refuses, and then has given back what it took.
  virtual void activate() = 0;
  /// Stops the head and gives the joints back as they were found. Does what it can on a lost connection; may be
  /// called more than once.
  virtual void release() = 0;
  /// What is worth telling and stops nothing (the name server is gone), a line each, since the last call. Allocates only
  /// where there is something.
  virtual std::vector<std::string> news() { return {}; }
};

}  // namespace saccade
