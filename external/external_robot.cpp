#include "external/external_robot.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/units.h"
#include "external/robot_connection.h"
#include "external/robot_frames.h"
#include "external/socket_address.h"
#include "head/head_model.h"
#include "robot/binary_semaphore.h"
#include "robot/event_queue.h"
#include "robot/event_timeline.h"
#include "robot/head_limits.h"
#include "robot/latest_value.h"
#include "robot/sender_clock.h"
#include "robot/steady_clock.h"

namespace saccade {
namespace {

using Ms = std::chrono::milliseconds;

constexpr auto heartbeat_period = Ms(10);
constexpr std::int64_t longest_tick_us = 35'000;  // after it no heartbeat is sent
constexpr auto longest_release = Ms(200);
constexpr auto longest_guard_stop = Ms(50);
constexpr std::int64_t first_reading_us = 1'000'000;
constexpr std::int64_t fresh_reading_us = 200'000;
constexpr std::int64_t oldest_gyro_us = 40'000;

using Reference = std::array<double, gaze_slots>;

/// The names and limits of the robot's joints against those of the file. Throws InputError.
void require_same_head(const RobotHello& hello, const HeadModel& head, const std::string& name) {
  const auto names = [](const auto& joints, std::size_t first) {
    std::string text;
    for (std::size_t i = first; i < joints.size(); ++i) text += (i > first ? ", " : "") + joints[i].name;
    return text.empty() ? std::string("none") : text;
  };
  const auto torso = static_cast<std::size_t>(hello.torso_joints);
  const std::string found = names(hello.joints, torso);
  const std::string expected = names(head.joints, static_cast<std::size_t>(head.torso_joints()));
  if (found != expected)
    throw InputError("head, with the robot at " + name, found, expected + " (" + head.name + ")");
  if (torso == 0) return;
  for (std::size_t i = 0; i < torso; ++i) {
    if (torso == static_cast<std::size_t>(head.torso_joints()) && hello.joints[i].name == head.joints[i].name)
      continue;
    throw InputError("torso of the robot at " + name, hello.joints[i].name,
                     "no joints, or those of " + head.name + " in its order");
  }
}

bool joint_follows(const JointsFrame& joints, std::size_t torso) {
  for (std::size_t i = torso; i < static_cast<std::size_t>(joints.count); ++i) {
    if (joints.drive[i] == JointDrive::references) return true;
  }
  return false;
}

}  // namespace

void describe(FieldVisitor& v, ExternalRobotConfig& config) {
  v.text("address", config.address,
         "where the robot's program listens: HOST:PORT, or the path of a Unix socket, with a /");
  v.require(parse_socket_address(config.address).has_value(), "address",
            config.address.empty() ? "nothing" : config.address, "HOST:PORT or a path with a /");
  v.real("timeout_s", config.timeout_s, {0.1, 60.0}, "time for the connection and for each answer");
  v.integer("queue_events", config.queue_events, {1000, 1e8},
            "events received and not read yet; of more the oldest are dropped");
}

std::string head_name(const ExternalRobotConfig& config) { return "external/" + config.address; }

struct ExternalRobot::Parts final : Clock, EventSource, HeadPort, ImuPort {
  Parts(const ExternalRobotConfig& config, const RobotContext& context)
      : connection(check_config("external", config), RobotClient::controller, steady),
        limits_(context.limits),
        head_from_imu(context.limits.head->head_from_imu),
        timeout(static_cast<int>(config.timeout_s * 1e3)) {
    const RobotHello& hello = connection.hello();
    if (hello.image_size != context.image_size)
      throw InputError("calibration", in_words(context.image_size),
                       in_words(hello.image_size) + ", the image of the robot at " + connection.name());
    torso = static_cast<std::size_t>(hello.torso_joints);
    joints = hello.joints.size() - torso;
    if (joints == 0) return;
    require_same_head(hello, *limits_.head, connection.name());
    JointLimits robots = limits_;
    for (std::size_t i = 0; i < joints; ++i) {
      const auto slot = torso_slots + static_cast<Eigen::Index>(i);
      robots.min_rad[slot] = hello.joints[torso + i].min_rad;
      robots.max_rad[slot] = hello.joints[torso + i].max_rad;
    }
    const CommonLimits common = common_limits(limits_, robots);
    limits_ = common.limits;
    limits_check = common.check;
    sender = std::thread([this] { send_frames(); });
  }
  ~Parts() override {
    if (!sender.joinable()) return;
    over = true;
    to_send.request();
    sender.join();
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  [[nodiscard]] PortStatus status() const {
    if (connection.lost()) return PortStatus::lost;
    return connection.ended() && connection_events_empty() ? PortStatus::ended : PortStatus::ok;
  }
  [[nodiscard]] bool connection_events_empty() const {
    return const_cast<RobotConnection&>(connection).events().size() == 0;
  }

  // Clock
  [[nodiscard]] std::int64_t now_us() const override { return steady.now_us(); }
  PortStatus wait_until(std::int64_t t_us) override {
    if (const PortStatus found = status(); found != PortStatus::ok) return found;
    ticked_us = steady.now_us();
    steady.wait_until(t_us);
    ticked_us = steady.now_us();
    return PortStatus::ok;
  }

  // EventSource
  [[nodiscard]] ImageSize image_size() const override { return connection.hello().image_size; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override {
    if (connection.lost()) return PortStatus::lost;
    connection.events().pop_until(t_us, events);
    return status();
  }
  [[nodiscard]] std::int64_t heard_us() const override { return connection.heard_us(); }
  [[nodiscard]] EventTraffic traffic() const override {
    auto& of = const_cast<RobotConnection&>(connection);
    return {of.packets(), of.events().size(), of.dropped()};
  }

  // HeadPort
  [[nodiscard]] JointLimits limits() const override { return limits_; }
  PortStatus read(HeadState& state) override {
    if (const PortStatus found = status(); found != PortStatus::ok) return found;
    const JointsFrame found = connection.joints();
    state = HeadState{};
    state.t_us = found.t_us;
    const auto& of_torso = limits_.head->joints;
    for (std::size_t i = 0; i < static_cast<std::size_t>(found.count); ++i) {
      const Eigen::Index slot =
          i < torso ? of_torso[i].slot : torso_slots + static_cast<Eigen::Index>(i - torso);
      state.position_rad[slot] = found.position_rad[i];
      state.velocity_rad_s[slot] = found.velocity_rad_s[i];
    }
    return PortStatus::ok;
  }
  [[nodiscard]] HeadDrives drives() const override {
    const JointsFrame found = connection.joints();
    HeadDrives drives;
    for (std::size_t i = 0; i < joints; ++i) {
      drives.joints[i] =
          i + torso < static_cast<std::size_t>(found.count) ? found.drive[torso + i] : JointDrive::unknown;
      if (drives.joints[i] == JointDrive::references && found.activation != activation)
        drives.joints[i] = JointDrive::held;  // it follows somebody else
    }
    return drives;
  }
  CommandResult command(const HeadCommand& reference_rad) override {
    if (const PortStatus found = status(); found != PortStatus::ok) return {found, false};
    if (activation == 0 || halted || !is_allowed(reference_rad, limits_)) return {PortStatus::ok, true};
    Reference reference{};
    for (std::size_t i = 0; i < joints; ++i) reference[i] = reference_rad[static_cast<Eigen::Index>(i)];
    stops = false;  // before the reference: see send_frames()
    references.write(reference);
    to_send.request();
    return {};
  }
  PortStatus stop() override {
    if (activation != 0 && !halted) {
      stops = true;
      to_send.request();
    }
    return status();
  }

  // ImuPort
  PortStatus read_imu(ImuReading& reading) override {
    if (const PortStatus found = status(); found != PortStatus::ok) return found;
    const ImuReading found = connection.imu();
    if (connection.has_imu() && found.t_us > reading.t_us) {
      reading.t_us = found.t_us;
      reading.angular_velocity_rad_s = head_from_imu * found.angular_velocity_rad_s;
      reading.acceleration_m_s2 = head_from_imu * found.acceleration_m_s2;
    }
    if (!connection.has_imu() || steady.now_us() - found.t_us > oldest_gyro_us)
      reading.angular_velocity_rad_s.setConstant(std::nan(""));
    return PortStatus::ok;
  }

  /// The thread that sends: what is wanted first a stop, then the newest reference; heartbeats between them.
  void send_frames() {
    std::uint64_t sent_reference = 1;  // the first value is none
    std::uint64_t told_activation = 0;
    bool told_stop = false;
    while (!over) {
      (void)to_send.wait_for(heartbeat_period);
      std::vector<std::byte>& out = frames;
      out.clear();
      const std::uint64_t wanted = halted ? 0 : wanted_activation.load();
      if (wanted != told_activation) {
        if (wanted != 0)
          write_number(RobotFrame::activate, wanted, out);
        else
          write_number(RobotFrame::release, told_activation, out);
        told_activation = wanted;
        sent_reference = references.count();
        told_stop = false;
      }
      if (told_activation != 0) {
        const std::uint64_t count =
            references.count();  // before `stops`: a reference after a stop is not skipped
        if (stops) {
          if (!told_stop) write_number(RobotFrame::stop, told_activation, out);
          told_stop = true;
          sent_reference = count;
        } else if (count != sent_reference) {
          const Reference reference = references.read();
          write_reference(told_activation, std::span(reference).first(joints), out);
          sent_reference = count;
          told_stop = false;
        }
        if (out.empty() && steady.now_us() - ticked_us < longest_tick_us)
          write_number(RobotFrame::heartbeat, told_activation, out);
      }
      if (!out.empty() && !connection.lost() && !connection.send(out)) return;
    }
  }

  /// Waits for a report of the joints; false if it does not come in time.
  template <class Holds>
  bool reported(Ms within, const Holds& holds) {
    const auto until = std::chrono::steady_clock::now() + within;
    while (!holds(connection.joints())) {
      if (connection.lost() || std::chrono::steady_clock::now() > until) return false;
      ticked_us = steady.now_us();  // this is no tick that hangs
      std::this_thread::sleep_for(Ms(1));
    }
    return true;
  }

  SteadyClock steady;
  RobotConnection connection;
  JointLimits limits_;
  StartUpCheck limits_check;
  Eigen::Matrix3d head_from_imu;
  Ms timeout;
  std::size_t torso = 0, joints = 0;
  std::atomic<std::int64_t> ticked_us = 0;
  std::atomic<std::uint64_t> activation = 0;         // 0: not active
  std::atomic<std::uint64_t> wanted_activation = 0;  // for the thread that sends
  std::uint64_t newest_activation = 0;
  std::atomic<bool> stops = false, halted = false, over = false;
  LatestValue<Reference> references;
  BinarySemaphore to_send;
  std::vector<std::byte> frames;
  std::thread sender;
};

ExternalRobot::ExternalRobot(const ExternalRobotConfig& config, const RobotContext& context)
    : parts_(std::make_unique<Parts>(config, context)) {}

ExternalRobot::~ExternalRobot() { release(); }

Clock& ExternalRobot::clock() { return *parts_; }
EventSource& ExternalRobot::events() { return *parts_; }
HeadPort* ExternalRobot::head() { return parts_->joints > 0 ? &*parts_ : nullptr; }
ImuPort* ExternalRobot::imu() { return parts_->connection.hello().has_imu ? &*parts_ : nullptr; }

std::vector<StartUpCheck> ExternalRobot::check() {
  Parts& p = *parts_;
  const std::string& name = p.connection.name();
  const std::int64_t until_us = p.steady.now_us() + first_reading_us;
  const auto wait = [&](const auto& there) {
    while (!there() && !p.connection.lost() && p.steady.now_us() < until_us)
      std::this_thread::sleep_for(Ms(1));
    return there() && !p.connection.lost();
  };
  std::vector<StartUpCheck> checks;
  const bool heard = wait([&] { return p.connection.packets() > 0; });
  checks.push_back({"camera of the robot at " + name, heard,
                    p.connection.lost() ? "not connected"
                    : heard ? in_words(p.image_size()) + ", " + std::to_string(p.connection.packets()) +
                                  " frames of events so far"
                            : "connected, but no frame of events within 1 s"});
  if (p.joints > 0) {
    const bool has = wait([&] { return p.connection.has_joints(); });
    HeadState state;
    const bool read_it = has && p.read(state) == PortStatus::ok;
    const std::int64_t age_us = p.steady.now_us() - state.t_us;
    checks.push_back({"joints are read", read_it && is_finite(state) && age_us < fresh_reading_us,
                      read_it ? std::to_string(p.joints) + " joints, newest reading " +
                                    std::to_string(age_us / 1000) + " ms old" +
                                    (is_finite(state) ? "" : ", not finite")
                              : "no frame of joints within 1 s"});
    checks.push_back(p.limits_check);
    checks.push_back({"the robot's own watchdog", true,
                      "stops the head " + std::to_string(p.connection.hello().watchdog_ms) +
                          " ms after the newest frame of its client"});
  }
  if (imu() != nullptr) {
    const bool has = wait([&] { return p.connection.has_imu(); });
    checks.push_back({"inertial sensor", has, has ? "readings arrive" : "no reading within 1 s"});
  }
  return checks;
}

void ExternalRobot::activate() {
  Parts& p = *parts_;
  if (p.joints == 0 || p.activation != 0) return;
  const std::string& name = p.connection.name();
  if (p.connection.lost()) throw RunError("the robot at " + name + " is not connected");
  const std::uint64_t number = ++p.newest_activation;
  p.ticked_us = p.steady.now_us();
  p.stops = false;
  p.halted = false;
  p.wanted_activation = number;
  p.to_send.request();
  const bool follows = p.reported(p.timeout, [&](const JointsFrame& found) {
    if (found.activation != number) return false;
    for (std::size_t i = 0; i < p.joints; ++i) {
      if (found.drive[p.torso + i] != JointDrive::references) return false;
    }
    return true;
  });
  if (!follows) {
    p.wanted_activation = 0;
    p.to_send.request();
    throw RunError("the joints of the robot at " + name + " do not follow references");
  }
  p.activation = number;
}

void ExternalRobot::release() {
  Parts& p = *parts_;
  if (p.activation.exchange(0) == 0) return;
  p.wanted_activation = 0;
  p.to_send.request();
  (void)p.reported(longest_release, [&](const JointsFrame& found) { return !joint_follows(found, p.torso); });
}

void ExternalRobot::halt() {
  Parts& p = *parts_;
  p.halted = true;
  p.to_send.request();
}

std::vector<std::string> ExternalRobot::news() {
  return parts_->connection.has_news() ? parts_->connection.news() : std::vector<std::string>{};
}

struct ExternalHeadStopper::Parts {
  explicit Parts(const ExternalRobotConfig& config)
      : connection(check_config("external", config), RobotClient::guard, steady) {}
  SteadyClock steady;
  RobotConnection connection;
  std::vector<std::byte> frame;
};

ExternalHeadStopper::ExternalHeadStopper(const ExternalRobotConfig& config, const RobotContext& context)
    : parts_(std::make_unique<Parts>(config)) {
  require_same_head(parts_->connection.hello(), *context.limits.head, parts_->connection.name());
}

ExternalHeadStopper::~ExternalHeadStopper() = default;

bool ExternalHeadStopper::is_connected() {
  const RobotConnection& connection = parts_->connection;
  return !connection.lost() && connection.has_joints() &&
         parts_->steady.now_us() - connection.joints().t_us < fresh_reading_us;
}

bool ExternalHeadStopper::stop() {
  Parts& p = *parts_;
  if (p.connection.lost()) return false;
  const std::int64_t sent_us = p.steady.now_us();
  p.frame.clear();
  write_number(RobotFrame::release, 0, p.frame);
  if (!p.connection.send(p.frame)) return false;
  const auto torso = static_cast<std::size_t>(p.connection.hello().torso_joints);
  const auto until = std::chrono::steady_clock::now() + longest_guard_stop;
  while (std::chrono::steady_clock::now() < until && !p.connection.lost()) {
    const JointsFrame found = p.connection.joints();
    if (found.t_us > sent_us && !joint_follows(found, torso)) return true;
    std::this_thread::sleep_for(Ms(1));
  }
  return false;
}

void add_external_robots(BackendRegistry& registry) {
  RobotBackend row =
      backend_row("external", "a robot in a program of your own, over a socket", ExternalRobotConfig{},
                  [](const ExternalRobotConfig& config, const RobotContext& context) {
                    return std::make_unique<ExternalRobot>(config, context);
                  });
  row.open_stopper = for_erased_config<ExternalRobotConfig>(
      [](const ExternalRobotConfig& config, const RobotContext& context) -> std::unique_ptr<HeadStopper> {
        return std::make_unique<ExternalHeadStopper>(config, context);
      });
  row.required = {"address"};
  registry.add(std::move(row));
}

}  // namespace saccade
