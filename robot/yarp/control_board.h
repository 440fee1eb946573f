#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "robot/joint_board.h"

namespace saccade {

/// Serves a JointBoard on YARP with the interface of an iCub control board: `PART/rpc:i`, `PART/command:i`, `PART/state:o`
/// and `PART/stateExt:o`, in degrees. Any YARP program that moves a part of an iCub (`remote_controlboard`, yarpmotorgui,
/// iKinGazeCtrl) can use it. It supports positions, speeds, modes and limits, but no motors, torques, currents or gains.
/// Clients cannot change limits.
///
/// The ports belong to YARP (controlBoard_nws_yarp) and run in its threads, the inputs behind a CheckedPort. Call the functions below from one thread.
class YarpControlBoard {
 public:
  struct Config {
    std::string part;                ///< prefix of the ports: /icub/head
    std::vector<std::string> names;  ///< of the joints
    double state_period_s = 0.01;    ///< of both state ports
  };
  /// Throws RunError if YARP cannot open the ports: no name server, or the name is in use.
  YarpControlBoard(const Config& config, const JointBoard& board);
  ~YarpControlBoard();

  /// Advances by dt_s (0 while the simulation is paused). `position_rad` and `velocity_rad_s`: the current joint state. The
  /// time stamp of the encoders is the time at which they are read, up to 0.2 s after this call, then that of this call.
  /// Returns the references from now on.
  Eigen::VectorXd step(const Eigen::VectorXd& position_rad, const Eigen::VectorXd& velocity_rad_s,
                       double dt_s);

  /// Counts of the requests of clients so far.
  struct Use {
    std::int64_t modes = 0;     ///< changes of a joint's mode to position-direct or velocity
    std::int64_t commands = 0;  ///< positions, references and velocities accepted
    std::int64_t refused = 0;   ///< rejected: for another mode than that of the joint, or not finite
  };
  [[nodiscard]] Use use() const;

  /// Sets references in position-direct mode on behalf of another controller of the same robot. Not counted in use().
  void drive(const Eigen::VectorXd& reference_rad);
  void stop();

 private:
  class Device;
  struct Ports;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Ports> ports_;
};

}  // namespace saccade
