#pragma once

#include <cstdint>
#include <vector>

#include "core/event.h"
#include "head/head_state.h"

namespace saccade {

/// The seam between the loop and the world: what a robot offers, and nothing more. Backends: sim/ (the
/// MuJoCo head), robot/replay (a recording), robot/yarp (the iCub), robot/fake (tests). tests/robot/port_conformance.h holds
/// what is promised here for every backend. A backend is used from one thread.

/// `ended` and `lost` are for good: each later call on that port says the same and changes nothing. A
/// recording that turns out to be broken is bad input: the call that meets it throws InputError.
enum class PortStatus {
  ok,
  ended,  ///< the recording is over or the world was closed; nothing more will come
  lost,   ///< the connection or the device failed
};

/// Time as the backend has it.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Never goes back. Microseconds in the clock of the events.
  [[nodiscard]] virtual std::int64_t now_us() const = 0;
  /// Returns when now_us() >= t_us: the simulator advances its world, a recording jumps, a robot waits.
  /// A time that has passed returns at once. `ended` or `lost` when that time will not come; `ended` only
  /// when every event has been read, so a loop that waits, reads and stops when the clock ends misses none.
  virtual PortStatus wait_until(std::int64_t t_us) = 0;
};

/// What came from a camera so far. A simulator and a recording have no packets and nothing waits in them: all zero
/// there but `dropped`, which is what the backend had to leave out.
struct EventTraffic {
  std::int64_t packets = 0;
  std::int64_t queued = 0;   ///< events that have come and were not read yet, now
  std::int64_t dropped = 0;  ///< events left out: the queue was full, outside the image, or back in time
};

/// The event camera of the left eye, or those of both: Event::camera tells them apart, their images have one size.
class EventSource {
 public:
  virtual ~EventSource() = default;
  [[nodiscard]] virtual ImageSize image_size() const = 0;
  /// Appends every event with time stamp <= t_us (t_us <= now) that was not delivered before, sorted by
  /// time and inside image_size(). Events may be late (stamps before the previous t_us, by at most 5 ms in
  /// the simulator) but the stamps that one source delivers, of both cameras, never go back. `ended` comes with the last
  /// events or after them; `lost` appends nothing.
  virtual PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) = 0;
  /// When the camera was last heard, in the clock's time: a packet, even an empty one (a still scene is silent).
  /// Where nothing can fall silent, now.
  [[nodiscard]] virtual std::int64_t heard_us() const = 0;
  [[nodiscard]] virtual EventTraffic traffic() const = 0;
};

/// Where the six head joints shall go now: position references, as in YARP's position-direct mode.
/// Rad, neck pitch to eyes vergence.
using HeadCommand = HeadJointVector;

/// Whether a head with these limits may take that reference: finite and inside them.
[[nodiscard]] inline bool is_allowed(const HeadCommand& reference_rad, const JointLimits& limits) {
  return reference_rad.allFinite() &&
         (reference_rad.array() >= limits.min_rad.tail<head_joint_count>().array()).all() &&
         (reference_rad.array() <= limits.max_rad.tail<head_joint_count>().array()).all();
}

/// The joints of neck and eyes (commanded) and of the torso (read only).
class HeadPort {
 public:
  virtual ~HeadPort() = default;
  [[nodiscard]] virtual JointLimits limits() const = 0;
  /// The newest encoder reading, finite unless a sensor fails; its stamp is never later than now and never goes back (how old it
  /// may be is the caller's decision). With `ended` or `lost` the state is left as it was.
  virtual PortStatus read(HeadState& state) = 0;
  /// Takes effect at once and holds until the next command. A reference outside limits() or not finite
  /// is refused whole (is_allowed; `refused` is true and the last one holds). A recorded head takes
  /// commands and moves as it did.
  struct CommandResult {
    PortStatus status = PortStatus::ok;
    bool refused = false;
  };
  virtual CommandResult command(const HeadCommand& reference_rad) = 0;
  /// The head stops where it is and holds there until the next command. May be called at any time and more than once.
  virtual PortStatus stop() = 0;
};

/// A gaze controller on the robot's side (iKinGazeCtrl), which moves the head by itself: it gets fixation points
/// instead of the head getting references.
class GazePort {
 public:
  virtual ~GazePort() = default;
  /// The point to fixate from now on: root frame, m, finite.
  virtual PortStatus look_at(const Eigen::Vector3d& target_m) = 0;
  /// The head stops where it is and holds there until the next look_at. May be called at any time and more than once.
  virtual PortStatus stop() = 0;
};

}  // namespace saccade
