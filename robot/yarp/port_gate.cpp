#include "robot/yarp/port_gate.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "robot/client_stream.h"
#include "robot/yarp/sockets.h"

namespace saccade {
namespace {

using Time = std::chrono::steady_clock::time_point;
using std::chrono::milliseconds;

constexpr auto introduction_time = milliseconds(2000);
constexpr auto message_time = milliseconds(5000);
constexpr auto look_period = milliseconds(20);
constexpr auto between_empty =
    milliseconds(20);  // connections of a port that ended before they sent anything
constexpr double clients_per_s = 50.0, most_clients_at_once = 200.0;
constexpr double accepts_per_s = 500.0, most_accepts_at_once = 200.0;
constexpr std::size_t buffer_bytes = std::size_t{1} << 17;
constexpr int sockets_beyond = 64;  // above the highest that the gate has seen

/// How often something may happen: `rate` in a second, `burst` at once.
class Allowance {
 public:
  Allowance(double rate, double burst) : rate_(rate), burst_(burst), left_(burst) {}
  [[nodiscard]] bool has_one(Time now) {
    left_ = std::min(burst_, left_ + rate_ * std::chrono::duration<double>(now - filled_).count());
    filled_ = now;
    return left_ >= 1.0;
  }
  void take() { left_ -= 1.0; }

 private:
  double rate_, burst_, left_;
  Time filled_ = std::chrono::steady_clock::now();
};

/// Bytes on their way to a socket.
class Outflow {
 public:
  std::vector<std::byte> bytes;
  [[nodiscard]] bool is_empty() const { return bytes.empty(); }
  [[nodiscard]] bool has_room() const { return bytes.size() < buffer_bytes; }
  /// Sends what the socket takes; false if it is closed.
  bool send(int socket) {
    if (bytes.empty()) return true;
    const ssize_t count = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    bytes.erase(bytes.begin(), bytes.begin() + count);
    return true;
  }
};

enum class Reading { nothing, bytes, end };

/// Reads what has come, at most a part of a buffer.
Reading receive(int socket, std::vector<std::byte>& bytes) {
  std::array<std::byte, 16'384> part;
  const ssize_t count = ::recv(socket, part.data(), part.size(), MSG_DONTWAIT);
  if (count < 0) return errno == EAGAIN || errno == EINTR ? Reading::nothing : Reading::end;
  if (count == 0) return Reading::end;
  bytes.assign(part.begin(), part.begin() + count);
  return Reading::bytes;
}

}  // namespace

class PortGate::Impl {
 public:
  Impl();
  ~Impl() { thread_.join(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// Closes all connections; nobody waits in next() any more.
  void end();
  /// For YARP's thread that listens on a socket: the next connection; it waits. no_gate at the end.
  int next(int listener);
  [[nodiscard]] Traffic traffic() const { return {clients_, refused_}; }

 private:
  /// A socket on which YARP listens.
  struct Port {
    ino_t inode = 0;
    int waiting = 0;         // threads of YARP in next()
    std::deque<File> queue;  // connections for them
    Allowance clients{clients_per_s, most_clients_at_once};
    Allowance accepts{accepts_per_s, most_accepts_at_once};
    Time empty{};  // when one that sent nothing was passed on
    bool owes_empty = false;
  };
  /// A client, before its introduction with its own socket alone.
  struct Client {
    int listener = -1;
    File outside, inside;  // to the client, and to YARP
    ClientStream stream;
    Outflow to_yarp, to_client;
    Time since{};               // of the connection
    Time whole{};               // when no message was half
    std::optional<Time> ended;  // when one side has closed it
    bool client_ended = false, yarp_ended = false;
    bool may_be_udp = false;                    // what it has sent stays in its socket
    bool has_sent = false;                      // something that was taken from there
    std::size_t outside_at = 0, inside_at = 0;  // in the list of polled files
  };

  void run();
  void accept_from(int listener, Port& port, Time now);
  void look_at_empty(Port& port, Time now);
  [[nodiscard]] bool is_own(int socket) const;
  /// Both return false if the client is to be closed.
  [[nodiscard]] bool introduce(Client& client, Time now);
  [[nodiscard]] bool serve(Client& client, short outside, short inside, Time now);
  [[nodiscard]] bool take_udp(Client& client);
  [[nodiscard]] bool read_client(Client& client);
  [[nodiscard]] bool connect_inside(Client& client);
  [[nodiscard]] std::optional<std::pair<File, File>> inner_connection() const;
  [[nodiscard]] int strangers() const;
  void give(Port& port, File file);
  void wake() const;

  File inner_listener_;
  sockaddr_in inner_address_{};
  std::array<File, 2> wake_;
  std::mutex mutex_;  // of ports_ and ending_
  std::condition_variable came_;
  std::map<int, Port> ports_;
  bool ending_ = false;
  std::list<Client> all_;  // of the thread alone
  /// Of clients by udp, whose end nobody sees: YARP has a thread for each of them, and replaces one of the same name.
  std::set<std::string> udp_names_;
  int highest_ = 0;
  std::atomic<std::int64_t> clients_ = 0, refused_ = 0;
  std::thread thread_;
};

PortGate::Impl::Impl() {
  inner_listener_ = File(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  inner_address_.sin_family = AF_INET;
  inner_address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::array<int, 2> pipe{-1, -1};
  if (!inner_listener_.is_open() ||
      ::bind(inner_listener_.get(), reinterpret_cast<const sockaddr*>(&inner_address_),
             sizeof inner_address_) != 0 ||
      ::listen(inner_listener_.get(), most_clients) != 0 || ::pipe2(pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0)
    throw RunError("no socket for the connections of clients: " + std::string(std::strerror(errno)));
  inner_address_ = local_of(inner_listener_.get());
  wake_ = {File(pipe[0]), File(pipe[1])};
  thread_ = std::thread([this] { run(); });
}

void PortGate::Impl::end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake();
}

void PortGate::Impl::wake() const {
  const char byte = 0;
  (void)!::write(wake_[1].get(), &byte, 1);
}

int PortGate::Impl::next(int listener) {
  std::unique_lock lock(mutex_);
  const ino_t inode = inode_of(listener);
  Port& port = ports_[listener];
  if (port.inode != inode) {  // another socket than the one that had this number
    port = Port();
    port.inode = inode;
    // YARP lets one connection wait (BACKLOG in TcpAcceptor.cpp): the others of a burst try again after 1, 3 and 7 s.
    (void)::listen(listener, most_clients);
  }
  ++port.waiting;
  wake();
  came_.wait(lock, [&] { return !port.queue.empty() || ending_; });
  --port.waiting;
  if (port.queue.empty()) return no_gate;
  const int file = port.queue.front().release();
  port.queue.pop_front();
  return file;
}

void PortGate::Impl::give(Port& port, File file) {
  set_blocking(file.get(), true);
  port.queue.push_back(std::move(file));
  came_.notify_all();
}

int PortGate::Impl::strangers() const {
  return static_cast<int>(
      std::ranges::count_if(all_, [](const Client& client) { return !client.inside.is_open(); }));
}

/// Whether the other end of a connection belongs to this process.
bool PortGate::Impl::is_own(int socket) const {
  const sockaddr_in remote = remote_of(socket);
  const sockaddr_in local = local_of(socket);
  if (remote.sin_addr.s_addr != local.sin_addr.s_addr && (ntohl(remote.sin_addr.s_addr) >> 24U) != 127)
    return false;
  for (int file = 3; file <= highest_ + sockets_beyond; ++file) {
    if (file != socket && same_socket(local_of(file), remote) && same_socket(remote_of(file), local))
      return true;
  }
  return false;
}

void PortGate::Impl::accept_from(int listener, Port& port, Time now) {
  while (port.accepts.has_one(now)) {
    pollfd came{listener, POLLIN, 0};  // the socket blocks
    if (::poll(&came, 1, 0) != 1) return;
    File file(::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!file.is_open()) return;
    port.accepts.take();
    highest_ = std::max(highest_, file.get());
    if (is_own(file.get())) {
      give(port, std::move(file));
      continue;
    }
    if (strangers() >= most_strangers) {
      all_.erase(std::ranges::find_if(all_, [](const Client& client) { return !client.inside.is_open(); }));
      ++refused_;
    }
    without_delay(file.get());
    Client& client = all_.emplace_back();
    client.listener = listener;
    client.outside = std::move(file);
    client.since = client.whole = now;
  }
}

/// A connection of this process with itself.
std::optional<std::pair<File, File>> PortGate::Impl::inner_connection() const {
  constexpr int patience_ms = 100;
  File mine(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!mine.is_open() ||
      ::connect(mine.get(), reinterpret_cast<const sockaddr*>(&inner_address_), sizeof inner_address_) != 0)
    return std::nullopt;
  for (;;) {
    pollfd came{inner_listener_.get(), POLLIN, 0};
    (void)::poll(&came, 1, patience_ms);
    File other(::accept4(inner_listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (!other.is_open()) return std::nullopt;
    // Another program may connect to that socket as well.
    if (same_socket(remote_of(other.get()), local_of(mine.get())))
      return std::pair(std::move(mine), std::move(other));
  }
}

/// A port of YARP that closes connects to itself, sends nothing, and waits until its acceptor has noticed.
void PortGate::Impl::look_at_empty(Port& port, Time now) {
  if (!port.owes_empty || port.waiting == 0 || now - port.empty < between_empty) return;
  port.owes_empty = false;
  port.empty = now;
  if (auto connection = inner_connection()) give(port, std::move(connection->second));
}

/// The connection to YARP of a client that has introduced itself.
bool PortGate::Impl::connect_inside(Client& client) {
  auto connection = inner_connection();
  if (!connection) return false;
  auto& [inside, other] = *connection;
  highest_ = std::max({highest_, inside.get(), other.get()});
  set_blocking(inside.get(), false);
  without_delay(inside.get());
  client.inside = std::move(inside);
  const std::lock_guard lock(mutex_);
  Port& port = ports_[client.listener];
  port.clients.take();
  give(port, std::move(other));
  ++clients_;
  return true;
}

/// Before its introduction: takes a client with the carrier udp, which YARP reads from another socket. Its own one goes to
/// YARP as it is, with what it has sent. Returns whether it may be a client of that kind.
bool PortGate::Impl::take_udp(Client& client) {
  std::array<std::byte, longest_introduction> bytes;
  const ssize_t count = ::recv(client.outside.get(), bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  if (count <= 0) return false;
  const UdpIntroduction found = udp_introduction(std::span(bytes).first(static_cast<std::size_t>(count)));
  if (!found.name) return found.may_be;
  const std::lock_guard lock(mutex_);
  Port& port = ports_[client.listener];
  const bool known = udp_names_.contains(*found.name);
  if (!known && udp_names_.size() >= most_clients) return false;
  udp_names_.insert(*found.name);
  port.clients.take();
  give(port, std::move(client.outside));
  ++clients_;
  return true;
}

bool PortGate::Impl::read_client(Client& client) {
  std::vector<std::byte> bytes;
  const Reading reading = receive(client.outside.get(), bytes);
  if (reading == Reading::end) client.client_ended = true;
  client.has_sent = true;
  if (client.stream.add(bytes, client.to_yarp.bytes)) return true;
  ++refused_;
  return false;
}

bool PortGate::Impl::introduce(Client& client, Time now) {
  if (client.client_ended) {
    const std::lock_guard lock(mutex_);
    if (!client.stream.has_part() && !client.stream.is_introduced())
      ports_[client.listener].owes_empty = true;
    return false;
  }
  if (client.stream.is_introduced()) {
    const auto known = static_cast<int>(all_.size()) - strangers();
    bool may = known < most_clients;
    if (may) {
      const std::lock_guard lock(mutex_);
      may = ports_[client.listener].clients.has_one(now);
    }
    if (may) return connect_inside(client);
  }
  if (now - client.since < introduction_time) return true;
  ++refused_;
  return false;
}

bool PortGate::Impl::serve(Client& client, short outside, short inside, Time now) {
  constexpr short readable = POLLIN | POLLHUP | POLLERR;
  if (client.may_be_udp || ((outside & readable) != 0 && !client.inside.is_open() && !client.has_sent)) {
    client.may_be_udp = take_udp(client);
    if (!client.outside.is_open()) return false;  // it is YARP's
    if (client.may_be_udp) return introduce(client, now);
  }
  if ((outside & readable) != 0 && !read_client(client)) return false;
  if (!client.inside.is_open()) return introduce(client, now);
  if ((inside & readable) != 0) {
    std::vector<std::byte> bytes;
    if (receive(client.inside.get(), bytes) == Reading::end) client.yarp_ended = true;
    client.to_client.bytes.insert(client.to_client.bytes.end(), bytes.begin(), bytes.end());
  }
  if (!client.to_yarp.send(client.inside.get()) || !client.to_client.send(client.outside.get())) return false;
  if (!client.stream.has_part() || !client.to_yarp.is_empty()) client.whole = now;
  if (client.client_ended || client.yarp_ended) {
    if (!client.ended) client.ended = now;
    // What came before the end goes on; YARP may still answer a client that sends nothing more.
    if (client.client_ended && client.to_yarp.is_empty()) ::shutdown(client.inside.get(), SHUT_WR);
    return !(client.yarp_ended && client.to_client.is_empty()) && now - *client.ended < message_time;
  }
  if (now - client.whole < message_time) return true;
  ++refused_;
  return false;
}

void PortGate::Impl::run() {
  std::vector<pollfd> files;
  std::vector<int> listeners;
  for (;;) {
    files.assign(1, {wake_[0].get(), POLLIN, 0});
    listeners.clear();
    const Time before = std::chrono::steady_clock::now();
    {
      const std::lock_guard lock(mutex_);
      if (ending_) break;
      for (auto& [listener, port] : ports_) {
        look_at_empty(port, before);
        if (!port.queue.empty() && inode_of(listener) != port.inode)
          port.queue.clear();  // YARP has closed it
        if (port.waiting == 0 || !port.queue.empty() || !port.accepts.has_one(before)) continue;
        files.push_back({listener, POLLIN, 0});
        listeners.push_back(listener);
      }
    }
    for (Client& client : all_) {
      short outside = 0;
      if (client.to_yarp.has_room() && !client.client_ended && !client.may_be_udp &&
          (client.inside.is_open() || !client.stream.is_introduced()))
        outside |= POLLIN;
      if (!client.to_client.is_empty()) outside |= POLLOUT;
      short inside = 0;
      if (client.to_client.has_room() && !client.yarp_ended) inside |= POLLIN;
      if (!client.to_yarp.is_empty()) inside |= POLLOUT;
      client.outside_at = files.size();
      files.push_back({outside != 0 ? client.outside.get() : -1, outside, 0});
      client.inside_at = files.size();
      files.push_back({client.inside.is_open() && inside != 0 ? client.inside.get() : -1, inside, 0});
    }
    (void)::poll(files.data(), files.size(), static_cast<int>(look_period.count()));
    if (files[0].revents != 0) {
      std::array<char, 64> bytes;
      (void)!::read(wake_[0].get(), bytes.data(), bytes.size());
    }
    const Time now = std::chrono::steady_clock::now();
    for (auto client = all_.begin(); client != all_.end();) {
      const bool stays =
          serve(*client, files[client->outside_at].revents, files[client->inside_at].revents, now);
      client = stays ? std::next(client) : all_.erase(client);
    }
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < listeners.size(); ++i) {
      if (files[1 + i].revents == 0) continue;
      Port& port = ports_[listeners[i]];
      if (port.waiting > 0 && inode_of(listeners[i]) == port.inode) accept_from(listeners[i], port, now);
    }
  }
  all_.clear();
  const std::lock_guard lock(mutex_);
  for (auto& [listener, port] : ports_) port.queue.clear();
  came_.notify_all();
}

// accept() has no other way to the gate.
struct PortGate::Current {
  std::mutex mutex;
  std::condition_variable changed;
  Impl* gate = nullptr;
  int users = 0;

  static Current& get() {
    static Current current;
    return current;
  }
  /// The next connection from the gate, or no_gate.
  int next(int listener) {
    std::unique_lock lock(mutex);
    if (gate == nullptr) return no_gate;
    Impl& found = *gate;
    ++users;
    lock.unlock();
    const int file = found.next(listener);
    lock.lock();
    --users;
    changed.notify_all();
    return file;
  }
};

PortGate::PortGate() : impl_(std::make_unique<Impl>()) {
  Current& current = Current::get();
  const std::lock_guard lock(current.mutex);
  SACCADE_CHECK(current.gate == nullptr);
  current.gate = impl_.get();
}

PortGate::~PortGate() {
  Current& current = Current::get();
  std::unique_lock lock(current.mutex);
  current.gate = nullptr;
  impl_->end();
  current.changed.wait(lock, [&] { return current.users == 0; });
}

PortGate::Traffic PortGate::traffic() const { return impl_->traffic(); }

int PortGate::next_connection(int listener) {
  if (local_of(listener).sin_family != AF_INET || !listens(listener)) return no_gate;
  return Current::get().next(listener);
}

}  // namespace saccade

/// Of YARP's acceptors: it waits until a client has introduced itself.
extern "C" int accept(int socket, sockaddr* address, socklen_t* length) {
  const int file = saccade::PortGate::next_connection(socket);
  if (file == saccade::PortGate::no_gate) return ::accept4(socket, address, length, 0);
  if (address != nullptr && length != nullptr) (void)::getpeername(file, address, length);
  return file;
}
