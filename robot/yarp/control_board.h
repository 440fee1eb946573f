#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "robot/joint_board.h"

namespace saccade {

/// A part of the iCub as its control board offers it on YARP: `PART/rpc:i`, `PART/command:i`, `PART/state:o` and
/// `PART/stateExt:o`, degrees on the wire, behind a JointBoard. Any YARP program that moves an iCub's part
/// (`remote_controlboard`, yarpmotorgui, iKinGazeCtrl) can move this one. Positions, speeds, modes and limits are served;
/// motors, torques, currents and gains are not. Limits cannot be changed from outside.
///
/// The ports are YARP's own (controlBoard_nws_yarp) and served from its threads; what is here is called from one thread.
class YarpControlBoard {
 public:
  struct Config {
    std::string part;                ///< prefix of the ports: /icub/head
    std::vector<std::string> names;  ///< of the joints
    double state_period_s = 0.01;    ///< of both state ports
  };
  /// Throws RunError where YARP opens no ports under that name: no name server, or the name is taken.
  YarpControlBoard(const Config& config, const JointBoard& board);
  ~YarpControlBoard();

  /// Where the joints are now, rad and rad/s, dt_s after the last call; 0 while the world stands still. The encoders'
  /// stamps are the time of this call. Gives the references that hold from now on.
  Eigen::VectorXd step(const Eigen::VectorXd& position_rad, const Eigen::VectorXd& velocity_rad_s,
                       double dt_s);

  /// What clients asked for so far.
  struct Use {
    std::int64_t modes = 0;     ///< changes of a joint's mode to position-direct or velocity
    std::int64_t commands = 0;  ///< positions, references and velocities taken
    std::int64_t refused = 0;   ///< of another mode than the joint's, or not finite
  };
  [[nodiscard]] Use use() const;

  /// Another controller of the same robot moves the joints, in position-direct mode; not counted in use().
  void drive(const Eigen::VectorXd& reference_rad);
  void stop();

 private:
  class Device;
  struct Ports;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Ports> ports_;
};

}  // namespace saccade
