#include "apps/serve/served_external.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "head/head_model.h"

namespace saccade {
namespace {

constexpr std::int64_t served_watchdog_ms = 60;
constexpr std::int64_t caught_up_us = 20'000;  // a delay that PacedRobot makes up for

SocketAddress address_at(const std::string& text) {
  const auto address = parse_socket_address(text);
  if (!address) throw InputError("--external", text, "HOST:PORT or a path with a /");
  return *address;
}

RobotHello hello_of(SimRobot& robot) {
  RobotHello hello;
  hello.image_size = robot.image_size();
  hello.watchdog_ms = served_watchdog_ms;
  hello.has_imu = robot.imu() != nullptr;
  const JointLimits limits = robot.limits();
  hello.torso_joints = limits.head->torso_joints();
  for (const HeadJoint& joint : limits.head->joints)
    hello.joints.push_back({joint.name, limits.min_rad[joint.slot], limits.max_rad[joint.slot],
                            limits.max_speed_rad_s[joint.slot]});
  return hello;
}

}  // namespace

ServedExternal::ServedExternal(const std::string& address, SimRobot& robot, Log log)
    : address_(address), robot_(robot), log_(std::move(log)), server_(address_at(address), hello_of(robot)) {}

void ServedExternal::idle() {
  HeadState state;
  robot_.read(state);
  exchange(state, {});
}

void ServedExternal::on_tick(const Tick& tick) {
  t_us_ = tick.t_us;
  exchange(*tick.head, tick.events);
}

void ServedExternal::exchange(const HeadState& state, std::span<const Event> events) {
  paused_us_ = std::max(paused_us_, clock_.now_us() - t_us_ - caught_up_us);
  const RobotServer::Wants wants = server_.receive();
  if (wants.hold) robot_.stop();
  if (wants.reference_rad) {
    HeadCommand reference_rad;
    for (int i = 0; i < gaze_slots; ++i)
      reference_rad[i] = wants.reference_rad->at(static_cast<std::size_t>(i));
    robot_.command(reference_rad);
  }
  shifted_.assign(events.begin(), events.end());
  for (Event& event : shifted_) event.t_us += paused_us_;
  JointsFrame joints;
  joints.t_us = state.t_us + paused_us_;
  for (const HeadJoint& joint : robot_.limits().head->joints) {
    const auto at = static_cast<std::size_t>(joints.count++);
    joints.position_rad[at] = state.position_rad[joint.slot];
    joints.velocity_rad_s[at] = state.velocity_rad_s[joint.slot];
  }
  ImuReading reading;
  const bool has_imu = robot_.imu() != nullptr && robot_.imu()->read_imu(reading) == PortStatus::ok;
  const Eigen::Matrix3d imu_from_head = robot_.limits().head->head_from_imu.transpose();
  reading.t_us += paused_us_;
  reading.angular_velocity_rad_s = imu_from_head * reading.angular_velocity_rad_s;
  reading.acceleration_m_s2 = imu_from_head * reading.acceleration_m_s2;
  server_.send(t_us_ + paused_us_, shifted_, joints, has_imu ? &reading : nullptr);
  events_ += static_cast<std::int64_t>(events.size());
  ++packets_;
  for (const std::string& line : server_.news()) log_(t_us_, line);
}

std::string ServedExternal::traffic() const {
  return fmt::format("{} events in {} frames; {} references for joints, {} rejected", events_, packets_,
                     server_.references(), server_.rejected());
}

}  // namespace saccade
