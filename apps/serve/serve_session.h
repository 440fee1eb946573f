#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/config/registry.h"

namespace saccade {

struct ServeOptions {
  std::filesystem::path scenario;
  std::filesystem::path out;  ///< empty: runs/NAME_served
  std::vector<std::string> assignments;
  std::optional<std::int64_t> seed;
  bool force = false;
  bool wait_for_client =
      false;                   ///< the world stands still until somebody reads the camera and takes the head
  bool endless = false;        ///< beyond the scenario's duration
  std::string robot = "icub";  ///< ports /ROBOT/head/..., /ROBOT/torso/...
  std::string gaze = "iKinGazeCtrl";         ///< ports /GAZE/...
  std::string camera = "/zynqGrabber/AE:o";  ///< port of the events
  std::string format = "packet";             ///< PacketFormat of it
  std::string codec = "ev2";                 ///< AddressCodec of it
  double state_period_ms = 10.0;             ///< of the head's state ports
};

/// The simulated robot of a scenario in real time on YARP, as if it were the iCub: an event camera, control boards of
/// head and torso, and a gaze controller with iKinGazeCtrl's ports. Nothing here detects or follows: that is what a
/// client does. Truth goes into a run folder, and the gaze that the client achieved is scored as in `saccade run`.
///
/// A millisecond of the world takes one of the clock. After a delay the world catches up to catch_up_us; what is more
/// is lost for good: the world's time slips against the clock, and the summary says by how much.
///
/// What the head does when a client is gone: with position-direct commands it holds the last reference, a velocity ends
/// after 100 ms (JointBoard), and the gaze controller keeps looking at the last target, as the iCub's do.
///
/// Returns the exit status. Throws InputError, RunError.
int serve(const ServeOptions& options, const Registry& registry);

}  // namespace saccade
