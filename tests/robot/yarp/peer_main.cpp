// A part of a robot in a process of its own, to be killed or halted: camera PORT | board PART
#include <unistd.h>
#include <yarp/os/Network.h>

#include <optional>
#include <string>

#include "tests/robot/yarp/peers.h"

int main(int, char** arguments) {
  const yarp::os::Network network;
  std::optional<saccade::CountingGrabber> grabber;
  std::optional<saccade::ServedBoard> board;
  if (std::string(arguments[1]) == "camera") {
    grabber.emplace(arguments[2]);
  } else {
    board.emplace(arguments[2], saccade::robot_limits_deg);
  }
  for (;;) ::pause();
}
