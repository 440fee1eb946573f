#pragma once

#include <memory>
#include <string>
#include <vector>

#include "robot/robot.h"
#include "robot/yarp/yarp_config.h"

namespace saccade {

/// The iCub on a YARP network, or what behaves like one. Built where CMake finds YARP; then SACCADE_YARP is defined for
/// whoever links saccade_yarp.
///
/// - Clock: the machine's steady clock, 0 when the robot was made.
/// - Events: from `camera.port`, in YARP's threads through EventTimeline into an EventQueue. `lost` when its connection
///   (with right_port, one of both) closes.
/// - Head, `control: joints`: references in position-direct mode through remote_controlboard, positions and their times
///   from PART/state:o, speeds as the board estimates them. limits() are the tightest of the robot's and ours. activate()
///   takes all six joints over, which needs them to be in a mode that holds them (not idle, not in fault); release()
///   stops them and sets the modes that were found. A connection that closes is `lost`; one that hangs shows as a state
///   that gets old.
/// - Head, `control: gaze`: targets to NAME/xd:i, never more often than target_interval_ms (the newest waits);
///   NAME/mono:i is not used, since a target here is a point already. Settings go over NAME/rpc at activate() and are put
///   back (`stor`, `rest`) at release(). Positions come from NAME/q:o, speeds are their differences; limits() are ours.
/// - The torso, where it is not told: upright and at rest.
/// - Losing the name server stops nothing: connections that are open live on. It is told by news().
///
/// A command costs the tick what YARP does to hand a message to the connection's own thread: it locks, copies and
/// allocates a little; it waits for nobody (a message that the last one still blocks is left out; YarpHead sends the last
/// one again).
///
/// All names of ours begin with `local` and are gone when the robot is; those of a process that was killed do not stand
/// in the way of the next.
class YarpRobot final : public Robot {
 public:
  /// Opens our ports and connects them; what is not there is found by check(), and its port says `lost`. `limits` are
  /// ours, rad. Throws InputError for a bad configuration, RunError without a name server or where `local` is in use.
  YarpRobot(const YarpConfig& config, const JointLimits& limits);
  ~YarpRobot() override;

  Clock& clock() override;
  EventSource& events() override;
  HeadPort* head() override;
  GazePort* gaze() override;
  /// Takes up to `timeout_s` per part that does not answer, and 1 s for the camera where it is silent.
  std::vector<StartUpCheck> check() override;
  void activate() override;
  void release() override;
  std::vector<std::string> news() override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace saccade
