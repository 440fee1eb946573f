// A part of a robot on YARP with faults on demand, in a process of its own: FACTS camera PORT | FACTS board PART.
// FACTS names the shared memory with RobotFacts.
#include <yarp/os/Network.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <thread>

#include "apps/deploy/shared_memory.h"
#include "core/random.h"
#include "core/units.h"
#include "robot/yarp/control_board.h"
#include "tests/robot/yarp/faults/robot_facts.h"
#include "tests/robot/yarp/peers.h"

namespace saccade {
namespace {

constexpr auto step = std::chrono::milliseconds(1);
constexpr double step_s = 1e-3;
constexpr double servo_s = 0.02;  // time constant
constexpr double moves_rad_s = 1.0 * rad_per_deg;
constexpr Eigen::Index faulty_joint = 2;

/// A message that is no packet of events: a few bytes of chance.
struct BrokenMessage final : yarp::os::PortWriter {
  std::vector<char> bytes;
  bool write(yarp::os::ConnectionWriter& writer) const override {
    writer.appendBlock(bytes.data(), bytes.size());
    return true;
  }
};

/// Whether a ball that circles in the image, wherever the head looks, covers a pixel. So the head never comes to rest.
bool covers(double t_s, int x, int y) {
  const double turn_rad = 2.0 * std::numbers::pi * t_s;
  const double dx = x - 64.0 - 12.0 * std::cos(turn_rad);
  const double dy = y - 69.0 - 12.0 * std::sin(turn_rad);
  return dx * dx + dy * dy <= 13.0 * 13.0;
}

/// Its events of the step that ends at t_s.
std::vector<WireEvent> ball_events(double t_s) {
  std::vector<WireEvent> events;
  for (int y = 40; y < 100; ++y) {
    for (int x = 35; x < 95; ++x) {
      const bool is_in = covers(t_s, x, y);
      if (is_in == covers(t_s - step_s, x, y)) continue;
      events.push_back(
          {0, encode_address({0, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), is_in, 0},
                             AddressCodec::ev2)});
    }
  }
  return events;
}

[[noreturn]] void run_camera(const RobotFacts& facts, const std::string& port) {
  Grabber grabber(port, PacketFormat::packet);
  BrokenMessage broken;
  const RandomStream random(1, "broken messages");
  auto due = std::chrono::steady_clock::now();
  for (std::int64_t tick = 1;; ++tick) {
    std::this_thread::sleep_until(due += step);
    if (facts.camera == RobotFacts::is_silent) continue;
    if (facts.camera == RobotFacts::sends_broken_messages) {
      const auto place = static_cast<std::uint64_t>(tick);
      broken.bytes.resize(1 + random.bits(1, place) % 100);
      for (std::size_t i = 0; i < broken.bytes.size(); ++i)
        broken.bytes[i] = static_cast<char>(random.bits(2 + i, place));
      grabber.port().write(broken);
      continue;
    }
    const EventPacket packet{1000, ball_events(step_s * static_cast<double>(tick))};
    grabber.send(packet, 5000.0 + step_s * static_cast<double>(tick));
  }
}

/// Six joints with servos of first order.
[[noreturn]] void run_board(RobotFacts& facts, const std::string& part) {
  const double min_deg[] = {-29, -19, -44, -29, -29, 1};
  const double max_deg[] = {16, 19, 44, 29, 29, 49};
  std::vector<JointBoard::Joint> joints;
  for (int j = 0; j < 6; ++j)
    joints.push_back({min_deg[j] * rad_per_deg, max_deg[j] * rad_per_deg, 400 * rad_per_deg});
  Eigen::VectorXd position_rad = Eigen::VectorXd::Zero(6);
  position_rad[5] = 5 * rad_per_deg;
  Eigen::VectorXd reference_rad = position_rad;
  YarpControlBoard board({part, {"pitch", "roll", "yaw", "tilt", "version", "vergence"}, 0.01},
                         JointBoard(joints, position_rad, true));
  std::int64_t commands = 0;
  auto due = std::chrono::steady_clock::now();
  for (;;) {
    std::this_thread::sleep_until(due += step);
    const std::int64_t now_ns = machine_ns();
    Eigen::VectorXd velocity_rad_s = (reference_rad - position_rad) / servo_s;
    if (facts.joints == RobotFacts::one_is_stuck) velocity_rad_s[faulty_joint] = 0.0;
    position_rad += step_s * velocity_rad_s;
    if (velocity_rad_s.cwiseAbs().maxCoeff() > moves_rad_s) facts.moved_ns = now_ns;
    Eigen::VectorXd read_rad = position_rad;
    if (facts.joints == RobotFacts::one_is_not_a_number)
      read_rad[faulty_joint] = std::numeric_limits<double>::quiet_NaN();
    if (facts.joints == RobotFacts::one_is_outside) read_rad[faulty_joint] = 60 * rad_per_deg;
    const Eigen::VectorXd next_rad = board.step(read_rad, velocity_rad_s, step_s);
    const std::int64_t next_commands = board.use().commands;
    if (next_rad.allFinite() && next_rad != reference_rad) {
      facts.held_ns = now_ns;
      if (next_commands != commands) {
        facts.referenced_ns = now_ns;
        ++facts.references;
      }
      reference_rad = next_rad;
    }
    commands = next_commands;
  }
}

}  // namespace
}  // namespace saccade

int main(int, char** arguments) {
  const yarp::os::Network network;
  saccade::SharedMemory memory(arguments[1], sizeof(saccade::RobotFacts));
  auto& facts = *static_cast<saccade::RobotFacts*>(memory.data());
  if (std::string(arguments[2]) == "camera") saccade::run_camera(facts, arguments[3]);
  saccade::run_board(facts, arguments[3]);
}
