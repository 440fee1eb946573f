#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "external/robot_frames.h"
#include "external/socket_address.h"

namespace saccade {

/// The robot's side of the protocol of robot_frames.h: offers a head and its camera on a socket. Used from one thread; no
/// call waits for a client. One client moves the head at a time; a client that is slow, or sends something else than the
/// protocol, is disconnected, and the others are served on.
class RobotServer {
 public:
  static constexpr std::size_t most_clients = 8;
  static constexpr std::size_t most_waiting_bytes = 8 << 20;  ///< for a client that does not read

  /// Listens. Throws RunError. The name of a Unix socket that nobody listens on is used again.
  RobotServer(const SocketAddress& address, RobotHello hello);
  ~RobotServer();
  RobotServer(const RobotServer&) = delete;
  RobotServer& operator=(const RobotServer&) = delete;

  /// What a client wants of the head since the last exchange.
  struct Wants {
    bool hold = false;  ///< the joints hold where they are; before the reference
    std::optional<std::array<double, gaze_slots>> reference_rad;  ///< newest accepted one, inside the limits
  };
  /// Accepts clients, reads their frames, and disconnects those that must go.
  [[nodiscard]] Wants receive();
  /// Sends to every client. `joints`: the number of the activation and the drives are filled in.
  void send(std::int64_t until_us, std::span<const Event> events, JointsFrame joints,
            const ImuReading* imu = nullptr);
  void send_text(std::string_view text);
  void send_end();

  /// Whether the joints follow a client's references.
  [[nodiscard]] bool follows() const { return activation_ != 0; }
  [[nodiscard]] int clients() const { return static_cast<int>(clients_.size()); }
  [[nodiscard]] std::int64_t references() const { return references_; }
  [[nodiscard]] std::int64_t rejected() const { return rejected_; }
  /// Lines about clients that came and went, since the last call.
  [[nodiscard]] std::vector<std::string> news();

 private:
  struct Client;
  void accept_clients(std::int64_t now_ns);
  /// What is wrong with the frame; empty if nothing.
  std::string take(Client& client, const FrameView& frame, std::int64_t now_ns, Wants& wants);
  void let_go(Wants& wants, std::string why);
  void send_to(Client& client, std::span<const std::byte> frames);
  void tell(std::string line);

  SocketAddress address_;
  RobotHello hello_;
  int listening_ = -1;
  std::list<Client> clients_;
  std::uint64_t activation_ = 0;   // whose references the joints follow
  const Client* owner_ = nullptr;  // who has it
  std::int64_t references_ = 0, rejected_ = 0;
  std::vector<std::byte> frames_;
  std::vector<std::string> news_;
};

}  // namespace saccade
