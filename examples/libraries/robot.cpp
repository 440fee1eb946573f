// The least that uses saccade::robot.
#include <saccade/robot/fake/fake_robot.h>

#include <cstdio>

int main() {
  saccade::FakeRobot robot({.end_us = 1000});
  std::printf("robot: %d pixels wide\n", robot.image_size().width);
}
