#pragma once

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
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "external/external_robot.h"
#include "external/robot_frames.h"
#include "external/socket_address.h"
#include "robot/event_queue.h"
#include "robot/event_timeline.h"
#include "robot/latest_value.h"
#include "robot/sender_clock.h"
#include "robot/steady_clock.h"

namespace saccade {

/// An ImuReading as LatestValue needs it.
struct ImuNumbers {
  std::int64_t t_us = 0;
  std::array<double, 3> angular_velocity_rad_s{}, acceleration_m_s2{};
};

/// A connection to the robot: a thread that receives frames, and the socket to send on.
class RobotConnection {
 public:
  static constexpr std::size_t most_news = 100;

  RobotConnection(const ExternalRobotConfig& config, RobotClient client, const SteadyClock& clock)
      : clock_(clock),
        name_(config.address),
        limit_(static_cast<int>(config.timeout_s * 1e3)),
        events_(static_cast<std::size_t>(config.queue_events)),
        socket_(connect_to(parse_socket_address(config.address).value(), limit_)) {
    std::vector<std::byte> out;
    write_client(client, out);
    try {
      if (!send(out)) throw RunError("the robot at " + name_ + " closed the connection");
      wait_for_hello();
    } catch (...) {
      ::close(socket_);
      throw;
    }
    receiver_ = std::thread([this] {
      receive();
      if (!ended_) ::shutdown(socket_, SHUT_RDWR);  // a robot whose client is gone holds its joints
    });
  }
  ~RobotConnection() {
    ::shutdown(socket_, SHUT_RDWR);
    receiver_.join();
    ::close(socket_);
  }
  RobotConnection(const RobotConnection&) = delete;
  RobotConnection& operator=(const RobotConnection&) = delete;

  /// Sends all bytes, from one thread. False, and lost, if the robot does not take them in time.
  bool send(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(sent));
        continue;
      }
      if (sent < 0 && errno == EINTR) continue;
      pollfd wait{socket_, POLLOUT, 0};
      if (sent < 0 && errno == EAGAIN && ::poll(&wait, 1, static_cast<int>(limit_.count())) > 0) continue;
      lose("the robot at " + name_ + " takes no more frames");
      return false;
    }
    return true;
  }

  [[nodiscard]] const RobotHello& hello() const { return hello_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] bool lost() const { return lost_; }
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] EventQueue& events() { return events_; }
  [[nodiscard]] JointsFrame joints() const { return joints_.read(); }
  [[nodiscard]] bool has_joints() const { return joints_.count() > 1; }
  [[nodiscard]] bool has_imu() const { return imu_.count() > 1; }
  [[nodiscard]] ImuReading imu() const {
    const ImuNumbers found = imu_.read();
    return {found.t_us, Eigen::Vector3d(found.angular_velocity_rad_s.data()),
            Eigen::Vector3d(found.acceleration_m_s2.data())};
  }
  [[nodiscard]] std::int64_t heard_us() const { return heard_us_; }
  [[nodiscard]] std::int64_t packets() const { return packets_; }
  [[nodiscard]] std::int64_t dropped() const { return dropped_ + events_.dropped(); }

  [[nodiscard]] bool has_news() const { return has_news_; }
  [[nodiscard]] std::vector<std::string> news() {
    const std::lock_guard lock(news_mutex_);
    has_news_ = false;
    return std::exchange(news_, {});
  }

 private:
  void tell(std::string line) {
    const std::lock_guard lock(news_mutex_);
    add_news(std::move(line));
  }
  void lose(std::string why) {
    const std::lock_guard lock(news_mutex_);
    if (lost_) return;
    add_news(std::move(why));
    lost_ = true;  // after the news: who sees it finds why
  }
  void add_news(std::string line) {
    if (news_.size() < most_news) news_.push_back(std::move(line));
    has_news_ = true;
  }

  /// False at the end of the connection.
  bool receive_some() {
    const std::span<std::byte> room = reader_.room();
    const ssize_t count = ::recv(socket_, room.data(), room.size(), 0);
    if (count < 0 && errno == EINTR) return true;
    if (count <= 0) return false;
    reader_.received(static_cast<std::size_t>(count));
    return true;
  }

  void wait_for_hello() {
    const auto until = std::chrono::steady_clock::now() + limit_;
    for (;;) {
      if (const auto frame = reader_.next()) {
        std::string problem = frame->type == RobotFrame::hello
                                  ? read_hello(frame->payload, hello_)
                                  : "found a frame of type " +
                                        std::to_string(static_cast<unsigned>(frame->type)) +
                                        ", expected hello (1) first";
        if (!problem.empty()) throw RunError("the robot at " + name_ + ": " + problem);
        return;
      }
      if (!reader_.problem().empty()) throw RunError("the robot at " + name_ + ": " + reader_.problem());
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
      pollfd wait{socket_, POLLIN, 0};
      if (left.count() <= 0 || ::poll(&wait, 1, static_cast<int>(left.count())) == 0)
        throw RunError("the robot at " + name_ + " sends no hello within " + std::to_string(limit_.count()) +
                       " ms");
      if (!receive_some())
        throw RunError("the robot at " + name_ + " closed the connection before its hello");
    }
  }

  void receive() {
    for (;;) {
      while (const auto frame = reader_.next()) {
        if (std::string problem = take(*frame); !problem.empty()) {
          lose("the robot at " + name_ + " sends an unreadable frame: " + problem);
          return;
        }
        if (ended_) return;
      }
      if (!reader_.problem().empty()) {
        lose("the robot at " + name_ + " sends an unreadable frame: " + reader_.problem());
        return;
      }
      if (!receive_some()) {
        lose("the robot at " + name_ + " closed the connection");
        return;
      }
    }
  }

  std::string take(const FrameView& frame) {
    const std::int64_t now_us = clock_.now_us();
    switch (frame.type) {
      case RobotFrame::events: {
        std::int64_t until_us = 0;
        if (std::string problem = read_events(frame.payload, until_us, received_); !problem.empty())
          return problem;
        add_events(until_us, now_us);
        return {};
      }
      case RobotFrame::joints: {
        JointsFrame joints;
        const int count = static_cast<int>(hello_.joints.size());
        if (std::string problem = read_joints(frame.payload, count, joints); !problem.empty()) return problem;
        joints.t_us = std::max(joints_us_, local(joints.t_us, now_us));
        joints_us_ = joints.t_us;
        joints_.write(joints);
        return {};
      }
      case RobotFrame::imu: {
        ImuReading reading;
        if (std::string problem = read_imu(frame.payload, reading); !problem.empty()) return problem;
        ImuNumbers numbers{local(reading.t_us, now_us), {}, {}};
        Eigen::Vector3d::Map(numbers.angular_velocity_rad_s.data()) = reading.angular_velocity_rad_s;
        Eigen::Vector3d::Map(numbers.acceleration_m_s2.data()) = reading.acceleration_m_s2;
        imu_.write(numbers);
        return {};
      }
      case RobotFrame::text: {
        std::string text;
        if (std::string problem = read_text(frame.payload, text); !problem.empty()) return problem;
        tell("the robot: " + text);
        return {};
      }
      case RobotFrame::end:
        ended_ = true;
        return {};
      default:
        return "found type " + std::to_string(static_cast<unsigned>(frame.type)) + ", expected 2 to 6";
    }
  }

  [[nodiscard]] std::int64_t local(std::int64_t t_us, std::int64_t now_us) {
    constexpr std::int64_t most_us = INT64_MAX / 4;  // sums of times do not overflow
    return sender_.to_local(std::clamp(t_us, -most_us, most_us), now_us);
  }

  void add_events(std::int64_t until_us, std::int64_t now_us) {
    constexpr std::int64_t longest_us = 10'000'000;
    const std::int64_t end_us = local(until_us, now_us);
    std::int64_t dropped = 0;
    std::size_t kept = 0;
    for (Event& event : received_) {
      const bool near = event.t_us <= until_us && event.t_us >= INT64_MIN / 4 && until_us <= INT64_MAX / 4 &&
                        until_us - event.t_us < longest_us;
      if (near) event.t_us = end_us - (until_us - event.t_us);
      if (near && hello_.image_size.contains(event.x, event.y) && forward_.admit(event))
        received_[kept++] = event;
      else
        ++dropped;
    }
    events_.push(std::span(received_).first(kept));
    dropped_ += dropped;
    ++packets_;
    heard_us_ = now_us;
  }

  const SteadyClock& clock_;
  std::string name_;
  std::chrono::milliseconds limit_;
  FrameReader reader_;
  RobotHello hello_;
  std::vector<Event> received_;
  SenderClock sender_;
  ForwardOnly forward_;
  std::int64_t joints_us_ = INT64_MIN;
  EventQueue events_;
  LatestValue<JointsFrame> joints_;
  LatestValue<ImuNumbers> imu_;
  std::atomic<std::int64_t> heard_us_ = 0, packets_ = 0, dropped_ = 0;
  std::atomic<bool> lost_ = false, ended_ = false, has_news_ = false;
  std::mutex news_mutex_;
  std::vector<std::string> news_;
  int socket_;
  std::thread receiver_;
};

}  // namespace saccade
