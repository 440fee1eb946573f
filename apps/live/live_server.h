#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace saccade {

/// Where a live page is offered.
struct LiveAddress {
  std::string host = "127.0.0.1";  ///< a number, IPv4 or IPv6
  std::uint16_t port = 0;          ///< 0: one that is free
};

/// Reads the value of `--web`: "" or "PORT" on loopback, "ADDRESS:PORT" elsewhere, "[ADDRESS]:PORT" for IPv6. Throws
/// InputError.
[[nodiscard]] LiveAddress live_address_of(const std::string& text);

/// Offers one page and a stream of messages by WebSocket, in a thread of its own. Nobody without the token gets anything; a
/// browser's page gets the stream only if it came from here (Origin).
///
/// What a client gets is bounded: one message is on its way and the newest waits, older ones are dropped for this client. What
/// a client may send is bounded too: headers of 8 KiB, messages of 1 KiB, 20 of them per second. One that does not answer for
/// 30 s is disconnected.
class LiveServer {
 public:
  struct Config {
    LiveAddress address;
    std::string page;                ///< HTML
    std::size_t most_clients = 128;  ///< connections; more are closed at once
    /// Called for the message `stop` of a client, in the server's thread; empty: no message is taken.
    std::function<void()> stop = {};
  };

  /// Listens from now on. Throws RunError where the address cannot be used.
  explicit LiveServer(Config config);
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;
  /// Closes all connections: those of browsers as at the end of a run (code 1000), within half a second.
  ~LiveServer();

  /// The page with its token: "http://127.0.0.1:8080/?token=...".
  [[nodiscard]] std::string link() const;
  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] const std::string& token() const;
  /// Stops that clients have requested.
  [[nodiscard]] std::uint64_t stops() const;
  /// Clients of the stream.
  [[nodiscard]] std::size_t clients() const;
  /// Messages that were dropped for slow clients.
  [[nodiscard]] std::uint64_t dropped() const;

  /// What every client gets first; binary.
  void set_greeting(std::string message);
  /// Sends a binary message to every client. Does not wait for any; where the server's thread is busy with the last one, this
  /// one is dropped.
  void publish(std::string message);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace saccade
