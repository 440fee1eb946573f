#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/live/live_server.h"
#include "config/registry.h"

namespace saccade {

struct ServeOptions {
  std::filesystem::path scenario;
  std::filesystem::path out;  ///< empty: runs/NAME_served
  std::vector<std::string> assignments;
  std::optional<std::int64_t> seed;
  bool force = false;
  std::optional<LiveAddress> web;  ///< of the live page; none: there is none
  bool wait_for_client =
      false;  ///< simulated time stands still until a client reads the camera and commands the head
  bool endless = false;        ///< beyond the scenario's duration
  std::string external;        ///< address at which the robot is offered by robot_frames.h instead of on YARP
  std::string robot = "icub";  ///< ports /ROBOT/head/..., /ROBOT/torso/...
  std::string gaze = "iKinGazeCtrl";         ///< ports /GAZE/...
  std::string camera = "/zynqGrabber/AE:o";  ///< port of the events
  std::string format = "packet";             ///< PacketFormat of it
  std::string codec = "ev2";                 ///< AddressCodec of it
  bool swap_polarity = false;                ///< YarpEventPort::Config::swap_polarity
  double state_period_ms = 10.0;             ///< of the head's state ports
};

/// Offers the simulated robot of a scenario on YARP in real time, with the iCub's ports: an event camera, control boards
/// of head and torso, and a gaze controller (iKinGazeCtrl's ports); or, with `external`, by the frames of
/// external/robot_frames.h. Detection and gaze control are the client's. Ground
/// truth goes into a run folder, and the gaze that the client achieves is scored as in `saccade run`.
///
/// Simulated time keeps pace with the wall clock, see PacedRobot.
///
/// After a client disconnects: the last position-direct reference holds, a velocity ends after 100 ms (JointBoard), and
/// the gaze controller keeps looking at the last target, as on the iCub.
///
/// Ends the program with status 0 after the duration and after an interrupt, which ends the run as planned, without closing
/// YARP's ports (ServedPorts::leave): no client delays or breaks the end. Throws InputError,
/// RunError; also if it is interrupted before a client came (wait_for_client), when there is nothing to report.
int serve(const ServeOptions& options, const Registry& registry);

}  // namespace saccade
