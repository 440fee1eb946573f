#pragma once

#include <memory>
#include <string>
#include <vector>

#include "robot/robot.h"
#include "robot/yarp/yarp_config.h"

namespace saccade {

/// Version of YARP that this was built with.
[[nodiscard]] std::string yarp_version();

/// Takes names of ports from the name server. The ports stay open.
void forget_names(const std::vector<std::string>& names);

/// An iCub on a YARP network, or a server with its interface. Built if CMake finds YARP; targets that link saccade_yarp
/// then have SACCADE_YARP defined.
///
/// - Clock: the steady clock of the machine, 0 at construction.
/// - Events: from `camera.port`, in YARP's threads through EventTimeline into an EventQueue. `lost` when its connection
///   (with right_port, one of the two) closes.
/// - Head, `control: joints`: references in position-direct mode through remote_controlboard, positions and their times
///   from PART/state:o, speeds as the board estimates them. limits() are the tighter ones of the robot's and the configured ones.
///   activate() sets the mode of all six joints and requires that each is in a mode that holds it (not idle, not in
///   fault); release() stops them and restores their modes. A closed connection is `lost`; with a blocked one the state
///   gets old.
/// - Head, `control: gaze`: targets to NAME/xd:i, never more often than target_interval_ms (the newest waits);
///   NAME/mono:i is not used, because targets are points. Settings are sent over NAME/rpc at activate() and restored
///   (`stor`, `rest`) at release(). Positions come from NAME/q:o, speeds are their differences; limits() are the configured
///   ones.
/// - Inertial sensor: the port imu.port, if it is configured (YarpImu).
/// - Torso: upright and at rest if no part is configured for it.
/// - Loss of the name server: open connections continue; news() reports it.
///
/// Sending a command takes the time in which YARP passes a message to the thread of the connection: it locks, copies and
/// allocates a little, but does not block (while the previous message is being sent, the new one is dropped; YarpHead
/// repeats the last one).
///
/// The names of all local ports begin with `local` and are unregistered by the destructor. Names left over from a killed
/// process are reused.
class YarpRobot final : public Robot {
 public:
  /// Opens the local ports and connects them. A missing connection is reported by check(), and its port is `lost`.
  /// `limits`: rad, in addition to those of the robot. Throws InputError for a configuration out of range, RunError
  /// without a name server or if `local` is in use.
  YarpRobot(const YarpConfig& config, const JointLimits& limits);
  ~YarpRobot() override;

  Clock& clock() override;
  EventSource& events() override;
  HeadPort* head() override;
  ImuPort* imu() override;
  GazePort* gaze() override;
  /// Takes up to `timeout_s` for each part that does not answer, and 1 s for a camera that sends nothing.
  std::vector<StartUpCheck> check() override;
  void activate() override;
  void release() override;
  void halt() override;
  std::vector<std::string> news() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The connection of `saccade guard` to the head of a robot on YARP, under names that begin with `local`/guard, the second
/// one of a process with `local`/guard/2, and so on. Position-
/// direct joints hold and change to position mode, so that their board rejects later references; a gaze controller gets
/// `stop`.
class YarpHeadStopper final : public HeadStopper {
 public:
  /// As YarpRobot. `head.control: none` has no head.
  YarpHeadStopper(const YarpConfig& config, const JointLimits& limits);
  ~YarpHeadStopper() override;

  [[nodiscard]] bool is_connected() override;
  bool stop() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Ports of YARP install a handler of SIGCHLD that collects every child of the process: nobody else would get the exit status
/// of a program, such as gnuplot, ffmpeg or a detector. Call it once the ports are open: the default applies again.
void keep_exit_statuses();

}  // namespace saccade
