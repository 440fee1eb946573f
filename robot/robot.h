#pragma once

#include <string>
#include <vector>

#include "robot/ports.h"

namespace saccade {

/// Result of one check before motors move.
struct StartUpCheck {
  std::string what;  ///< "event port /zynqGrabber/AE:o"
  bool passed = false;
  std::string found;  ///< what was found; where the check failed, also what was expected
};

/// A robot as the loop uses it: clock, event camera and head, and the steps that start and end the control of its
/// motors. A simulator, a recording, the real robot and the robot of the tests implement it, so that a session runs on
/// any of them.
///
///     connected --check()--> activate() --> ports move the head --> release()
///
/// A real robot rejects commands and targets before activate() and after release(); events and joints are read
/// throughout. A simulator and a recording need neither call: there both do nothing.
class Robot {
 public:
  virtual ~Robot() = default;

  virtual Clock& clock() = 0;
  virtual EventSource& events() = 0;
  virtual HeadPort* head() = 0;  ///< null without joints (a bare recording)
  virtual GazePort* gaze() {
    return nullptr;
  }  ///< null if the head takes references; else `head` is only read
  /// Checks every condition for moving the motors and lists all results. Moves nothing.
  virtual std::vector<StartUpCheck> check() { return {}; }
  /// Takes control of the joints. Throws RunError if the robot refuses; the joints are then as before.
  virtual void activate() {}
  /// Stops the head and restores the joints' previous control modes, as far as the connection permits. May be called
  /// more than once.
  virtual void release() {}
  /// Messages since the last call that do not stop the run ("the name server is gone"), one per line. Allocates only if
  /// there are any.
  virtual std::vector<std::string> news() { return {}; }
};

}  // namespace saccade
