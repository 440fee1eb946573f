#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace saccade {

/// Where a program listens.
struct SocketAddress {
  std::string path;        ///< of a Unix socket; empty: TCP
  std::string host, port;  ///< port: 1 to 65535
};

/// `HOST:PORT` with a name, an IPv4 address or an IPv6 address in brackets; or a path, which contains a `/`. None for
/// other text.
[[nodiscard]] std::optional<SocketAddress> parse_socket_address(std::string_view text);

/// `localhost:5000`, or the path.
[[nodiscard]] std::string text_of(const SocketAddress& address);

/// A connected stream socket; TCP sends without delay. Tries again while nobody listens there. Throws RunError where
/// nobody does within the limit of the wall clock, or the host is unknown.
[[nodiscard]] int connect_to(const SocketAddress& address, std::chrono::milliseconds limit);

/// A stream socket that listens, without waiting in accept(), for up to `waiting` connections. The file of a Unix socket
/// that nobody listens on any more is replaced. Throws RunError.
[[nodiscard]] int listen_on(const SocketAddress& address, int waiting);
/// TCP sends without delay.
void send_at_once(int socket, const SocketAddress& address);

}  // namespace saccade
