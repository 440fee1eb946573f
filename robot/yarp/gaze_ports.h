#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "head/head_state.h"

namespace saccade {

/// The ports of iKinGazeCtrl: inputs NAME/xd:i, NAME/mono:i, NAME/stereo:i, NAME/angles:i and NAME/rpc, outputs NAME/x:o,
/// NAME/q:o, NAME/angles:o and NAME/events:o. Requests are passed on as text in the notation of YARP; a message on one of
/// the other input ports becomes the equivalent request `look ...`. A message of more than
/// longest_bottle bytes, or with counts beyond its end, is discarded, and its sender loses the connection.
class YarpGazePorts {
 public:
  /// Returns the reply to a request. Called from several threads of YARP at the same time.
  using Answer = std::function<std::string(const std::string& request)>;

  /// Throws RunError if YARP cannot open the ports: no name server, or the name is in use.
  YarpGazePorts(const std::string& name, Answer answer);
  ~YarpGazePorts();

  /// Sends the current state of the robot; of position_rad the iCub's joints, the first joint_count slots. No fixation
  /// point is sent while the optical axes have none. Slow readers miss messages.
  void send(const Eigen::Vector3d& fixation_m, const JointVector& position_rad,
            const Eigen::Vector3d& angles_deg, const std::vector<std::string>& events);

 private:
  struct Ports;
  std::unique_ptr<Ports> ports_;
};

}  // namespace saccade
