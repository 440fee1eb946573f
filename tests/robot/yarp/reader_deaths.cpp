// Kills readers of the ports of a served robot with SIGKILL while it sends every millisecond: COUNT. Each death is one of four
// connections at once. Status 1 if the sender does not notice one; a crash of the sender ends the program.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "core/random.h"
#include "robot/yarp/event_port.h"
#include "robot/yarp/gaze_ports.h"
#include "tests/robot/yarp/yarp_world.h"

namespace saccade {
namespace {

/// Sends as saccade serve does.
class Sender {
 public:
  Sender() : thread_([this] { run(); }) {}
  ~Sender() {
    ending_ = true;
    thread_.join();
  }
  [[nodiscard]] int readers() const { return camera_.readers(); }

 private:
  void run() {
    const std::vector<std::string> events = {"motion-done"};
    const auto start = std::chrono::steady_clock::now();
    for (std::int64_t tick = 1; !ending_; ++tick) {
      std::this_thread::sleep_until(start + std::chrono::milliseconds(tick));
      const std::array<Event, 3> seen = {Event{1000 * tick, 5, 60, true, 0},
                                         Event{1000 * tick, 6, 60, false, 0},
                                         Event{1000 * tick, 7, 60, true, 0}};
      camera_.send(seen, 1000 * tick);
      if (tick % 10 == 0) gaze_.send({-0.5, 0.0, 0.3}, JointVector::Zero(), {0.0, 0.0, 5.0}, events);
    }
  }

  YarpEventPort camera_{{}};
  YarpGazePorts gaze_{"/iKinGazeCtrl", [](const std::string&) { return std::string("[ack]"); }};
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

}  // namespace
}  // namespace saccade

int main(int, char** arguments) {
  using namespace saccade;
  const int count = std::atoi(arguments[1]);
  YarpWorld& world = YarpWorld::get();
  const Sender sender;
  const RandomStream random(1, "deaths of readers");
  for (int i = 0; i < count; ++i) {
    Child reader({SACCADE_YARP_PEER, "reader", "/reader" + std::to_string(i % 7), "/zynqGrabber/AE:o",
                  "/iKinGazeCtrl/x:o", "/iKinGazeCtrl/q:o", "/iKinGazeCtrl/events:o"},
                 world / "reader.log");
    if (!eventually(20.0, [&] { return sender.readers() == 1; })) {
      std::printf("reader %d did not connect\n", i);
      return 1;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(
        static_cast<std::int64_t>(random.uniform(5e3, 8e4, 0, static_cast<std::uint64_t>(i)))));
    reader.kill();
    if (!eventually(5.0, [&] { return sender.readers() == 0; })) {
      std::printf("the death of reader %d was not noticed\n", i);
      return 1;
    }
  }
  std::printf("%d readers of four ports each were killed\n", count);
  return testing::Test::HasFailure() ? 1 : 0;
}
