#include "apps/serve/served_robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "core/error.h"
#include "robot/yarp/yarp_robot.h"

namespace saccade {
namespace {

constexpr int gaze_report_ticks = 10;              // of iKinGazeCtrl's ports: 10 ms
constexpr std::int64_t commands_end_us = 100'000;  // a stream of commands with a longer pause has ended

/// The value of an enumeration by its name.
template <class Enum>
Enum choice(const char* option, const std::string& name, const std::vector<std::string>& names) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) throw InputError(option, name, fmt::format("one of {}", fmt::join(names, ", ")));
  return static_cast<Enum>(found - names.begin());
}

JointBoard board_of(const JointLimits& limits, const JointVector& position_rad, std::span<const Joint> joints,
                    bool movable) {
  std::vector<JointBoard::Joint> ranges;
  Eigen::VectorXd position(static_cast<Eigen::Index>(joints.size()));
  for (const Joint joint : joints) {
    position[static_cast<Eigen::Index>(ranges.size())] = position_rad[joint];
    ranges.push_back({limits.min_rad[joint], limits.max_rad[joint], limits.max_speed_rad_s[joint]});
  }
  return {ranges, position, movable};
}

constexpr std::array head_joints = {neck_pitch, neck_roll, neck_yaw, eyes_tilt, eyes_version, eyes_vergence};
constexpr std::array torso_motors = {torso_yaw, torso_roll, torso_pitch};  // the order of the part torso

std::vector<std::string> names_of(std::span<const Joint> joints) {
  std::vector<std::string> names;
  for (const Joint joint : joints) names.emplace_back(joint_names.at(static_cast<std::size_t>(joint)));
  return names;
}

IkinGazeConfig ikingaze_of(GazeControllerConfig config) {
  const IkinGazeConfig* const ikingaze = config.get_if<IkinGazeConfig>();
  return ikingaze != nullptr ? *ikingaze : IkinGazeConfig{};
}

std::vector<std::string> port_names(const ServeOptions& options) {
  std::vector<std::string> names = {options.camera};
  for (const char* part : {"head", "torso"}) {
    for (const char* port :
         {"rpc:i", "command:i", "state:o", "stateExt:o", "rpc:i/checked", "command:i/checked"})
      names.push_back(fmt::format("/{}/{}/{}", options.robot, part, port));
  }
  for (const char* port :
       {"xd:i", "mono:i", "stereo:i", "angles:i", "x:o", "q:o", "angles:o", "events:o", "rpc"})
    names.push_back(fmt::format("/{}/{}", options.gaze, port));
  return names;
}

HeadState state_of(SimRobot& robot) {
  HeadState state;
  robot.read(state);
  return state;
}

}  // namespace

ServedRobot::ServedRobot(const ServeOptions& options, const Scenario& scenario, SimRobot& robot, Log log)
    : opened_(fmt::format("/{0}/head, /{0}/torso, {1} and /{2} are open", options.robot, options.camera,
                          options.gaze)),
      robot_(robot),
      log_(std::move(log)),
      port_names_(port_names(options)),
      gaze_(ikingaze_of(scenario.gaze.controller), scenario.gaze.controller.limits, robot.limits(),
            scenario.calibration.camera,
            scenario.sim.both_eyes() ? scenario.right_calibration.camera : scenario.calibration.camera,
            state_of(robot).position_rad, robot.imu() != nullptr),
      camera_({options.camera, choice<PacketFormat>("--format", options.format, packet_format_names()),
               choice<AddressCodec>("--codec", options.codec, address_codec_names()), 100'000,
               options.swap_polarity}),
      head_({"/" + options.robot + "/head", names_of(head_joints), options.state_period_ms * 1e-3},
            board_of(robot.limits(), state_of(robot).position_rad, head_joints, true)),
      torso_({"/" + options.robot + "/torso", names_of(torso_motors), options.state_period_ms * 1e-3},
             board_of(robot.limits(), state_of(robot).position_rad, torso_motors, false)),
      gaze_ports_("/" + options.gaze, [this](const std::string& request) { return gaze_.answer(request); }) {
  keep_exit_statuses();
}

bool ServedRobot::has_client() {
  return camera_.readers() > 0 && (head_.use().modes + head_.use().commands + gaze_.report().requests > 0);
}

void ServedRobot::idle() {
  step_boards(state_of(robot_), 0.0);
  paused_us_ += World::tick_us;
  camera_.send({}, robot_.now_us() + paused_us_);
  send_gaze_reports();
}

void ServedRobot::on_tick(const Tick& tick) {
  const double dt_s = static_cast<double>(tick.t_us - t_us_) * 1e-6;
  t_us_ = tick.t_us;
  last_state_ = *tick.head;
  ImuReading reading;
  const bool has_imu = robot_.imu() != nullptr && robot_.imu()->read_imu(reading) == PortStatus::ok;
  if (const auto reference_rad = gaze_.step(*tick.head, dt_s, has_imu ? &reading : nullptr))
    head_.drive(*reference_rad);
  robot_.command(step_boards(*tick.head, dt_s));
  shifted_.assign(tick.events.begin(), tick.events.end());
  for (Event& event : shifted_) event.t_us += paused_us_;
  camera_.send(shifted_, tick.t_us + paused_us_);
  events_ += static_cast<std::int64_t>(tick.events.size());
  send_gaze_reports();
  log_changes();
}

void ServedRobot::leave() { forget_names(port_names_); }

void ServedRobot::announce_end() { camera_.send_end(t_us_ + paused_us_); }

std::string ServedRobot::traffic() const {
  const YarpControlBoard::Use use = head_.use();
  const PortGate::Traffic clients = gate_->traffic();
  return fmt::format(
      "{} events in {} packets, {} events left out; {} commands for joints, {} rejected; {} requests to the "
      "gaze controller; {} connections of clients, {} refused",
      events_, camera_.messages(), camera_.dropped(), use.commands, use.refused, requests_, clients.clients,
      clients.refused);
}

HeadCommand ServedRobot::step_boards(const HeadState& state, double dt_s) {
  Eigen::VectorXd position(3), velocity(3);
  for (int i = 0; i < 3; ++i) {
    position[i] = state.position_rad[torso_motors.at(static_cast<std::size_t>(i))];
    velocity[i] = state.velocity_rad_s[torso_motors.at(static_cast<std::size_t>(i))];
  }
  torso_.step(position, velocity, dt_s);
  HeadCommand reference_rad = HeadCommand::Zero();
  reference_rad.head<head_joint_count>() =
      head_.step(state.position_rad.segment<head_joint_count>(torso_slots),
                 state.velocity_rad_s.segment<head_joint_count>(torso_slots), dt_s);
  return reference_rad;
}

void ServedRobot::send_gaze_reports() {
  const GazeServer::Report report = gaze_.report();
  pending_events_.insert(pending_events_.end(), report.events.begin(), report.events.end());
  target_m_ = report.target_m;
  requests_ = report.requests;
  if (++ticks_ % gaze_report_ticks != 0) return;
  gaze_ports_.send(report.fixation_m, report.position_rad, report.angles_deg, pending_events_);
  pending_events_.clear();
}

void ServedRobot::log_changes() {
  if (const int readers = camera_.readers(); readers != readers_) {
    log_(t_us_, fmt::format("the camera has {} reader{}", readers, readers == 1 ? "" : "s"));
    readers_ = readers;
  }
  if (const std::int64_t commands = head_.use().commands; commands != commands_) {
    if (!commanded_) log_(t_us_, "commands come for the head's joints");
    commanded_ = true;
    commands_ = commands;
    commanded_us_ = t_us_;
  } else if (commanded_ && t_us_ - commanded_us_ >= commands_end_us) {
    log_(t_us_, "no command for the head's joints for 100 ms: they hold");
    commanded_ = false;
  }
  if (target_m_.has_value() != has_target_) {
    has_target_ = target_m_.has_value();
    log_(t_us_, has_target_ ? "the gaze controller has a target" : "the gaze controller was stopped");
  }
}

}  // namespace saccade
