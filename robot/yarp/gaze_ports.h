#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "head/head_state.h"

namespace saccade {

/// The ports of iKinGazeCtrl without what is behind them: in NAME/xd:i, NAME/mono:i, NAME/stereo:i, NAME/angles:i and
/// NAME/rpc, out NAME/x:o, NAME/q:o, NAME/angles:o and NAME/events:o. What comes in is handed on as text, as YARP writes
/// a message: what a port of its own says is the request `look ...` of the same meaning.
class YarpGazePorts {
 public:
  /// A request's reply. Called from YARP's threads, several at a time.
  using Answer = std::function<std::string(const std::string& request)>;

  /// Throws RunError where YARP opens no ports under that name: no name server, or the name is taken.
  YarpGazePorts(const std::string& name, Answer answer);
  ~YarpGazePorts();

  /// Sends what the robot does now, rad; a fixation point that there is none of is not sent. Whoever reads slowly
  /// misses some.
  void send(const std::optional<Eigen::Vector3d>& fixation_m, const JointVector& position_rad,
            const Eigen::Vector3d& angles_deg, const std::vector<std::string>& events);

 private:
  struct Ports;
  std::unique_ptr<Ports> ports_;
};

}  // namespace saccade
