// A part of a robot in a process of its own, to be killed or halted: camera PORT | board PART | reader NAME PORT...
#include <unistd.h>
#include <yarp/os/Network.h>

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tests/robot/yarp/peers.h"

int main(int, char** arguments) {
  const yarp::os::Network network;
  std::optional<saccade::CountingGrabber> grabber;
  std::optional<saccade::ServedBoard> board;
  struct Discard final : yarp::os::PortReader {
    bool read(yarp::os::ConnectionReader& reader) override {
      std::vector<char> bytes(reader.getSize());
      return reader.expectBlock(bytes.data(), bytes.size());
    }
  } discard;
  std::deque<yarp::os::Port> readers;
  if (std::string(arguments[1]) == "camera") {
    grabber.emplace(arguments[2]);
  } else if (std::string(arguments[1]) == "board") {
    board.emplace(arguments[2], saccade::robot_limits_deg);
  } else {
    for (char** port = arguments + 3; *port != nullptr; ++port) {
      yarp::os::Port& input = readers.emplace_back();
      input.setReader(discard);
      input.open(arguments[2] + ("/" + std::to_string(readers.size())));
      yarp::os::Network::connect(*port, input.getName(), "fast_tcp");
    }
  }
  for (;;) ::pause();
}
