#include "external/robot_server.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace saccade {
namespace {

constexpr std::int64_t longest_greeting_ns = 2'000'000'000;
constexpr int most_blocks = 16;  // of 64 kB from one client in one exchange
constexpr std::size_t most_lines = 100;

std::int64_t steady_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

struct RobotServer::Client {
  explicit Client(int connected, std::int64_t now_ns) : socket(connected), heard_ns(now_ns) {}
  ~Client() { ::close(socket); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  int socket;
  std::int64_t heard_ns;  ///< newest frame, or its connection
  std::optional<RobotClient> kind;
  FrameReader reader;
  std::vector<std::byte> waiting;  ///< bytes that its socket did not take yet
  std::string goes;                ///< why it is disconnected; empty: it stays
};

RobotServer::RobotServer(const SocketAddress& address, RobotHello hello)
    : address_(address), hello_(std::move(hello)), listening_(listen_on(address, most_clients)) {}

RobotServer::~RobotServer() {
  ::close(listening_);
  if (!address_.path.empty()) ::unlink(address_.path.c_str());
}

void RobotServer::tell(std::string line) {
  if (news_.size() < most_lines) news_.push_back(std::move(line));
}

std::vector<std::string> RobotServer::news() { return std::exchange(news_, {}); }

void RobotServer::accept_clients(std::int64_t now_ns) {
  while (clients_.size() < most_clients) {
    const int connected = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (connected < 0) return;
    send_at_once(connected, address_);
    Client& client = clients_.emplace_back(connected, now_ns);
    frames_.clear();
    hello_.now_us = now_ns / 1000;
    write_hello(hello_, frames_);
    send_to(client, frames_);
  }
}

void RobotServer::let_go(Wants& wants, std::string why) {
  activation_ = 0;
  owner_ = nullptr;
  wants.hold = true;
  wants.reference_rad.reset();
  tell("the joints hold: " + why);
}

std::string RobotServer::take(Client& client, const FrameView& frame, std::int64_t now_ns, Wants& wants) {
  client.heard_ns = now_ns;
  if (!client.kind) {
    RobotClient kind{};
    if (frame.type != RobotFrame::client)
      return "found a frame of type " + std::to_string(static_cast<unsigned>(frame.type)) +
             ", expected client (16) first";
    if (std::string problem = read_client(frame.payload, kind); !problem.empty()) return problem;
    client.kind = kind;
    tell(kind == RobotClient::guard ? "a guard is connected" : "a client is connected");
    return {};
  }
  const int joints = static_cast<int>(hello_.joints.size()) - hello_.torso_joints;
  std::uint64_t number = 0;
  if (frame.type == RobotFrame::reference) {
    std::array<double, gaze_slots> reference_rad{};
    if (std::string problem = read_reference(frame.payload, joints, number, reference_rad); !problem.empty())
      return problem;
    bool allowed = owner_ == &client && number == activation_ && activation_ != 0;
    for (int i = 0; i < joints && allowed; ++i) {
      const RobotHello::Joint& joint = hello_.joints[static_cast<std::size_t>(hello_.torso_joints + i)];
      const double value = reference_rad.at(static_cast<std::size_t>(i));
      allowed = value >= joint.min_rad && value <= joint.max_rad;  // not a number: neither
    }
    ++(allowed ? references_ : rejected_);
    if (allowed) wants.reference_rad = reference_rad;
    return {};
  }
  if (frame.type < RobotFrame::activate || frame.type > RobotFrame::heartbeat)
    return "found a frame of type " + std::to_string(static_cast<unsigned>(frame.type)) +
           ", expected 17 to 21";
  if (std::string problem = read_number(frame.payload, number); !problem.empty()) return problem;
  if (frame.type == RobotFrame::activate) {
    if (client.kind != RobotClient::controller || number == 0)
      return "activate: found number " + std::to_string(number) +
             " of a client that may not, expected a controller's, above 0";
    if (owner_ != nullptr && owner_ != &client) {
      tell("a second client wants the joints: they follow the first one");
      return {};
    }
    activation_ = number;
    owner_ = &client;
    wants.hold = true;
    wants.reference_rad.reset();
    tell("the joints follow a client");
  } else if (frame.type == RobotFrame::release) {
    if (activation_ != 0 && (client.kind == RobotClient::guard || owner_ == &client))
      let_go(wants,
             client.kind == RobotClient::guard ? "the guard stopped them" : "their client released them");
  } else if (frame.type == RobotFrame::stop && owner_ == &client && number == activation_) {
    wants.hold = true;
    wants.reference_rad.reset();
  }
  return {};
}

RobotServer::Wants RobotServer::receive() {
  Wants wants;
  const std::int64_t now_ns = steady_ns();
  accept_clients(now_ns);
  for (Client& client : clients_) {
    for (int block = 0; block < most_blocks && client.goes.empty(); ++block) {
      const std::span<std::byte> room = client.reader.room();
      const ssize_t count = ::recv(client.socket, room.data(), room.size(), MSG_DONTWAIT);
      if (count < 0 && (errno == EAGAIN || errno == EINTR)) break;
      if (count <= 0) {
        client.goes = "it closed the connection";
        break;
      }
      client.reader.received(static_cast<std::size_t>(count));
      while (client.goes.empty()) {
        const auto frame = client.reader.next();
        if (!frame) break;
        client.goes = take(client, *frame, now_ns, wants);
      }
      if (client.goes.empty()) client.goes = client.reader.problem();
    }
    if (client.goes.empty() && !client.kind && now_ns - client.heard_ns > longest_greeting_ns)
      client.goes = "no frame client within 2 s";
  }
  for (auto client = clients_.begin(); client != clients_.end();) {
    const bool owns = owner_ == &*client;
    if (owns && !client->goes.empty()) let_go(wants, client->goes);
    if (owns && client->goes.empty() && now_ns - client->heard_ns > 1'000'000 * hello_.watchdog_ms)
      let_go(wants, "no frame of their client for " + std::to_string(hello_.watchdog_ms) + " ms");
    if (client->goes.empty()) {
      ++client;
      continue;
    }
    tell("a client is disconnected: " + client->goes);
    client = clients_.erase(client);
  }
  return wants;
}

void RobotServer::send_to(Client& client, std::span<const std::byte> frames) {
  if (!client.goes.empty()) return;
  client.waiting.insert(client.waiting.end(), frames.begin(), frames.end());
  std::size_t done = 0;
  while (done < client.waiting.size()) {
    const ssize_t sent = ::send(client.socket, client.waiting.data() + done, client.waiting.size() - done,
                                MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && errno != EAGAIN) client.goes = "it closed the connection";
    if (sent <= 0) break;
    done += static_cast<std::size_t>(sent);
  }
  client.waiting.erase(client.waiting.begin(), client.waiting.begin() + static_cast<std::ptrdiff_t>(done));
  if (client.waiting.size() > most_waiting_bytes) client.goes = "it does not read";
}

void RobotServer::send(std::int64_t until_us, std::span<const Event> events, JointsFrame joints,
                       const ImuReading* imu) {
  frames_.clear();
  do {
    const std::span<const Event> some = events.first(std::min(events.size(), most_frame_events));
    events = events.subspan(some.size());
    write_events(events.empty() ? until_us : some.back().t_us, some, frames_);
  } while (!events.empty());
  joints.activation = activation_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints.count); ++i)
    joints.drive[i] = activation_ != 0 && i >= static_cast<std::size_t>(hello_.torso_joints)
                          ? JointDrive::references
                          : JointDrive::held;
  if (joints.count > 0) write_joints(joints, frames_);
  if (imu != nullptr) write_imu(*imu, frames_);
  for (Client& client : clients_) send_to(client, frames_);
}

void RobotServer::send_text(std::string_view text) {
  frames_.clear();
  write_text(text, frames_);
  for (Client& client : clients_) send_to(client, frames_);
}

void RobotServer::send_end() {
  frames_.clear();
  write_end(frames_);
  for (Client& client : clients_) send_to(client, frames_);
}

}  // namespace saccade
