#pragma once

#include <yarp/os/Bottle.h>
#include <yarp/os/ConnectionReader.h>
#include <yarp/os/Port.h>
#include <yarp/os/PortReader.h>

#include <mutex>
#include <optional>
#include <string>

#include "robot/yarp/yarp_network.h"

namespace saccade {

/// Reads a whole message of at most longest_bottle bytes, whose counts are checked before YARP believes them. None for
/// another message: it is discarded, and its sender loses the connection.
[[nodiscard]] std::optional<yarp::os::Bottle> checked_message(yarp::os::ConnectionReader& reader);

/// Takes the name of an input port of this process that YARP reads itself, such as those of controlBoard_nws_yarp, and passes
/// on to that port what checked_message() accepts, and its replies back. YARP's own ports believe every count and length,
/// so that one message can end the program. Requests of several clients are answered one after another.
class CheckedPort final : private yarp::os::PortReader {
 public:
  enum class Kind {
    requests,  ///< any message; they are answered
    commands,  ///< what remote_controlboard streams: a list that begins with a vocabulary, and a list of numbers
  };
  /// `name`: a port that is open. It keeps its socket, which only this object is connected to from now on. Throws RunError
  /// if YARP cannot open a port.
  CheckedPort(const std::string& name, Kind kind);
  ~CheckedPort() override;
  CheckedPort(const CheckedPort&) = delete;
  CheckedPort& operator=(const CheckedPort&) = delete;

 private:
  bool read(yarp::os::ConnectionReader& reader) override;

  YarpNetwork network_{name_server_timeout_s};
  Kind kind_;
  yarp::os::Port in_;
  yarp::os::Port out_;
  std::mutex mutex_;  // of out_
};

}  // namespace saccade
