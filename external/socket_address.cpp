#include "external/socket_address.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <thread>

#include "core/error.h"

namespace saccade {
namespace {

using WallClock = std::chrono::steady_clock;

/// Linux applies a socket's time limit of sending to connect() too.
void limit_sending(int socket, std::chrono::milliseconds limit) {
  timeval time{};
  time.tv_sec = limit.count() / 1000;
  time.tv_usec = limit.count() % 1000 * 1000;
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &time, sizeof time);
}

/// The connected socket, or -1 and errno.
int try_connect(const sockaddr* address, socklen_t bytes, std::chrono::milliseconds limit) {
  const int socket = ::socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return -1;
  limit_sending(socket, limit);
  if (::connect(socket, address, bytes) != 0) {
    const int error = errno;
    ::close(socket);
    errno = error;
    return -1;
  }
  return socket;
}

sockaddr_un unix_name(const SocketAddress& address) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (address.path.size() >= sizeof name.sun_path) {
    throw InputError("socket", address.path,
                     "a path of less than " + std::to_string(sizeof name.sun_path) + " bytes");
  }
  std::ranges::copy(address.path, name.sun_path);
  return name;
}

int try_unix(const SocketAddress& address, std::chrono::milliseconds limit) {
  const sockaddr_un name = unix_name(address);
  return try_connect(reinterpret_cast<const sockaddr*>(&name), sizeof name, limit);
}

int try_tcp(const SocketAddress& address, std::chrono::milliseconds limit) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found);
  if (error != 0)
    throw RunError("no address of " + text_of(address) + ": " + std::string(::gai_strerror(error)));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
  int socket = -1;
  for (const addrinfo* one = found; one != nullptr && socket < 0; one = one->ai_next)
    socket = try_connect(one->ai_addr, one->ai_addrlen, limit);
  return socket;
}

/// -1 and errno where it cannot listen there.
int try_listen(const sockaddr* address, socklen_t bytes, int waiting) {
  const int socket = ::socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return -1;
  const int on = 1;
  if (address->sa_family != AF_UNIX) ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(socket, address, bytes) == 0 && ::listen(socket, waiting) == 0) return socket;
  const int error = errno;
  ::close(socket);
  errno = error;
  return -1;
}

/// Removes the file of a Unix socket that nobody listens on.
void remove_left_socket(const sockaddr_un& name) {
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return;
  const bool refused =
      ::connect(probe, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0 && errno == ECONNREFUSED;
  ::close(probe);
  struct stat found {};
  if (refused && ::stat(name.sun_path, &found) == 0 && S_ISSOCK(found.st_mode)) ::unlink(name.sun_path);
}

}  // namespace

std::optional<SocketAddress> parse_socket_address(std::string_view text) {
  SocketAddress address;
  if (text.find('/') != std::string_view::npos) {
    address.path = text;
    return address;
  }
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size() || number < 1 || number > 65535)
    return std::nullopt;
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  address.host = host;
  address.port = port;
  return address;
}

std::string text_of(const SocketAddress& address) {
  if (!address.path.empty()) return address.path;
  const bool is_ipv6 = address.host.find(':') != std::string::npos;
  return (is_ipv6 ? "[" + address.host + "]" : address.host) + ":" + address.port;
}

int connect_to(const SocketAddress& address, std::chrono::milliseconds limit) {
  constexpr auto pause = std::chrono::milliseconds(50);
  const WallClock::time_point deadline = WallClock::now() + limit;
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - WallClock::now());
    const auto least = std::max(left, std::chrono::milliseconds(1));
    const int socket = address.path.empty() ? try_tcp(address, least) : try_unix(address, least);
    if (socket >= 0) {
      send_at_once(socket, address);
      return socket;
    }
    const int error = errno;
    if (WallClock::now() + pause >= deadline) {
      throw RunError("no connection to " + text_of(address) + " within " + std::to_string(limit.count()) +
                     " ms: " + std::strerror(error));
    }
    std::this_thread::sleep_for(pause);
  }
}

void send_at_once(int socket, const SocketAddress& address) {
  const int on = 1;
  if (address.path.empty()) ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

int listen_on(const SocketAddress& address, int waiting) {
  int socket = -1;
  if (!address.path.empty()) {
    const sockaddr_un name = unix_name(address);
    remove_left_socket(name);
    socket = try_listen(reinterpret_cast<const sockaddr*>(&name), sizeof name, waiting);
  } else {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (const int error = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found);
        error != 0)
      throw RunError("no address of " + text_of(address) + ": " + std::string(::gai_strerror(error)));
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
    for (const addrinfo* one = found; one != nullptr && socket < 0; one = one->ai_next)
      socket = try_listen(one->ai_addr, one->ai_addrlen, waiting);
  }
  if (socket < 0) throw RunError("cannot listen at " + text_of(address) + ": " + std::strerror(errno));
  return socket;
}

}  // namespace saccade
