// A counting camera in a process of its own, to be killed: PORT
#include <unistd.h>
#include <yarp/os/Network.h>

#include "tests/robot/yarp/peers.h"

int main(int, char** arguments) {
  const yarp::os::Network network;
  const saccade::CountingGrabber grabber(arguments[1]);
  for (;;) ::pause();
}
