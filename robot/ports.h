#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/event.h"
#include "head/head_state.h"
#include "head/imu_reading.h"

namespace saccade {

/// Interface between the loop and a robot: clock, event camera, head, gaze controller. Backends: sim/ (the MuJoCo head),
/// robot/replay (a recording), robot/yarp (the iCub), robot/fake (tests). tests/robot/port_conformance.h tests these
/// contracts on every backend. A backend is used from one thread.

/// Status of a port. `ended` and `lost` are final: every later call on that port returns the same and has no effect.
/// A broken recording is bad input: the call that reads the broken place throws InputError.
enum class PortStatus {
  ok,
  ended,  ///< end of the recording, or the simulated world was closed; no more data
  lost,   ///< the connection or the device failed
};

/// Clock of a backend.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Microseconds in the clock of the events. Never goes back.
  [[nodiscard]] virtual std::int64_t now_us() const = 0;
  /// Returns when now_us() >= t_us: the simulator advances its world, a recording jumps, a robot waits. Returns at once
  /// if t_us has passed. Returns `ended` or `lost` if t_us is never reached; `ended` only after every event was read, so
  /// that a loop that waits, reads, and stops when the clock ends misses none.
  virtual PortStatus wait_until(std::int64_t t_us) = 0;
};

/// Counters of a camera since its start. A simulator and a recording have no packets and no queue: all zero but
/// `dropped`.
struct EventTraffic {
  std::int64_t packets = 0;
  std::int64_t queued = 0;   ///< events received and not read yet
  std::int64_t dropped = 0;  ///< events lost or discarded: queue full, outside the image, or back in time
};

/// Event camera of the left eye, or of both eyes: Event::camera is the eye; both images have the same size.
class EventSource {
 public:
  virtual ~EventSource() = default;
  [[nodiscard]] virtual ImageSize image_size() const = 0;
  /// Appends every event with time stamp <= t_us (t_us <= now) that was not delivered before, sorted by time and inside
  /// image_size(). Events may be late (stamps before the previous t_us, by at most 5 ms in the simulator), but the time
  /// stamps of one source, of both cameras together, never go back. `ended` comes with the last events or after them;
  /// `lost` appends nothing.
  virtual PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) = 0;
  /// Arrival of the newest packet, us of the clock; packets may be empty (a still scene has no events). Now, for
  /// backends that cannot fall silent.
  [[nodiscard]] virtual std::int64_t heard_us() const = 0;
  [[nodiscard]] virtual EventTraffic traffic() const = 0;
};

/// What holds a joint, as its board reports it.
enum class JointDrive : std::uint8_t {
  unknown,     ///< no report
  references,  ///< it follows the references of HeadPort::command
  held,        ///< its board holds it in another mode: position, velocity, mixed
  off,         ///< switched off: nothing holds it
  fault,       ///< hardware fault
};

/// The newest reports about the joints of a head.
struct HeadDrives {
  std::array<JointDrive, gaze_slots> joints{};  ///< those that gaze commands, the neck first

  /// The same for each joint.
  [[nodiscard]] static HeadDrives all(JointDrive drive) {
    HeadDrives drives;
    drives.joints.fill(drive);
    return drives;
  }
};

/// Position references of the joints that gaze commands, rad, the neck first, as in YARP's position-direct mode.
using HeadCommand = HeadJointVector;

/// Whether a head with these limits accepts the reference: finite and inside them.
[[nodiscard]] inline bool is_allowed(const HeadCommand& reference_rad, const JointLimits& limits) {
  return reference_rad.allFinite() &&
         (reference_rad.array() >= limits.min_rad.tail<gaze_slots>().array()).all() &&
         (reference_rad.array() <= limits.max_rad.tail<gaze_slots>().array()).all();
}

/// Joints of neck and eyes (commanded) and of the torso (read only).
class HeadPort {
 public:
  virtual ~HeadPort() = default;
  [[nodiscard]] virtual JointLimits limits() const = 0;
  /// LatestValue encoder reading, finite unless a sensor fails. Its time stamp is never later than now and never goes back;
  /// the caller decides how old it may be. With `ended` or `lost` the state stays unchanged.
  virtual PortStatus read(HeadState& state) = 0;
  /// What holds the joints, as last reported. Backends without control modes follow references always.
  [[nodiscard]] virtual HeadDrives drives() const { return HeadDrives::all(JointDrive::references); }
  /// Takes effect at once and holds until the next command. A reference that is not finite or outside limits() is
  /// rejected as a whole (is_allowed; `rejected` is true and the last reference holds). A recorded head accepts commands
  /// and moves as recorded.
  struct CommandResult {
    PortStatus status = PortStatus::ok;
    bool rejected = false;
  };
  virtual CommandResult command(const HeadCommand& reference_rad) = 0;
  /// The head stops and holds its position until the next command. May be called at any time and more than once.
  virtual PortStatus stop() = 0;
};

/// Inertial measurement unit in the head.
class ImuPort {
 public:
  virtual ~ImuPort() = default;
  /// LatestValue reading. Its time stamp is never later than now and never goes back. With `ended` or `lost` the reading stays
  /// unchanged.
  virtual PortStatus read_imu(ImuReading& reading) = 0;
};

/// A gaze controller on the robot (iKinGazeCtrl) that moves the head itself: it takes fixation points instead of joint
/// references.
class GazePort {
 public:
  virtual ~GazePort() = default;
  /// Fixates this point from now on: root frame, m, finite.
  virtual PortStatus look_at(const Eigen::Vector3d& target_m) = 0;
  /// The head stops and holds its position until the next look_at. May be called at any time and more than once.
  virtual PortStatus stop() = 0;
};

}  // namespace saccade
