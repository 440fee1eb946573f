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
  virtual HeadPort* head() = 0;               ///< null without joints (a bare recording)
  virtual ImuPort* imu() { return nullptr; }  ///< null without an inertial measurement unit
  virtual GazePort* gaze() {
    return nullptr;
  }  ///< null if the head takes references; else `head` is only read
  /// Checks every condition for moving the motors and lists all results. Moves nothing.
  virtual std::vector<StartUpCheck> check() { return {}; }
  /// Takes control of the joints. Throws RunError if the robot refuses; the joints are then as before.
  virtual void activate() {}
  /// Stops the head and restores the previous control modes of the joints that still follow references, as far as the
  /// connection permits. A joint that was switched off meanwhile, or that another program moves, stays as it is. May be
  /// called more than once.
  virtual void release() {}
  /// Stops the head from any thread, also while another thread hangs in a call of this robot or of its ports. From then
  /// on commands and targets have no effect until the next activate(). Waits for no lock that a call of the ports holds.
  virtual void halt() {}
  /// Messages since the last call that do not stop the run ("the name server is gone"), one per line. Allocates only if
  /// there are any.
  virtual std::vector<std::string> news() { return {}; }
};

/// Stops a head that another process moves, over a connection of its own. Used from one thread.
class HeadStopper {
 public:
  virtual ~HeadStopper() = default;
  /// Whether a stop would reach the head now.
  [[nodiscard]] virtual bool is_connected() = 0;
  /// The joints that follow references hold their position and follow no reference until they are activated again.
  /// A joint that is switched off stays off. Returns false if the head was not reached.
  virtual bool stop() = 0;
};

}  // namespace saccade
