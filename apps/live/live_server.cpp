#include "apps/live/live_server.h"

#include <fmt/format.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string_view>
#include <thread>
#include <utility>

// After <utility>, which Boost 1.74 does not include.
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "core/error.h"

namespace saccade {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using beast::error_code;

constexpr auto longest_request = std::chrono::seconds(10);
constexpr auto longest_silence = std::chrono::seconds(30);
constexpr auto longest_goodbye = std::chrono::milliseconds(500);
constexpr auto pause_after_failure = std::chrono::milliseconds(100);
constexpr std::size_t longest_header = 8 << 10;
constexpr std::size_t longest_message = 1 << 10;  // of a client
constexpr int most_messages_per_s = 20;
constexpr std::string_view stop_message = "stop";

/// 128 random bits.
std::string random_token() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", static_cast<std::uint32_t>(random()));
  return token;
}

/// In a time that does not depend on where the texts differ.
bool is_same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
  return difference == 0;
}

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

/// The path of a request's target, and its token.
std::pair<std::string_view, std::string_view> parts_of(std::string_view target) {
  const std::size_t query = target.find('?');
  if (query == std::string_view::npos) return {target, {}};
  constexpr std::string_view key = "token=";
  const std::string_view rest = target.substr(query + 1);
  return {target.substr(0, query), rest.starts_with(key) ? rest.substr(key.size()) : std::string_view{}};
}

using Message = std::shared_ptr<const std::string>;

}  // namespace

LiveAddress live_address_of(const std::string& text) {
  LiveAddress address;
  std::string_view port = text;
  if (const std::size_t colon = text.rfind(':'); colon != std::string::npos) {
    address.host = text.substr(0, colon);
    if (address.host.starts_with('[') && address.host.ends_with(']'))
      address.host = address.host.substr(1, address.host.size() - 2);
    port = std::string_view(text).substr(colon + 1);
  }
  error_code error;
  asio::ip::make_address(address.host, error);
  const auto number = std::from_chars(port.data(), port.data() + port.size(), address.port);
  const bool is_number = number.ec == std::errc() && number.ptr == port.data() + port.size();
  if (error || (!is_number && !text.empty()))
    throw InputError("--web", text,
                     "PORT, ADDRESS:PORT with an address in numbers, or nothing for a free port");
  return address;
}

struct LiveServer::Implementation {
  class Client;

  explicit Implementation(Config given)
      : config(std::move(given)), acceptor(io), pause(io), token(random_token()) {
    error_code error;
    const tcp::endpoint endpoint(asio::ip::make_address(config.address.host), config.address.port);
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error)
      throw RunError(fmt::format("--web: {}:{} cannot be used: {}", config.address.host, config.address.port,
                                 error.message()));
    port = acceptor.local_endpoint().port();
    const std::string host =
        endpoint.address().is_v6() ? "[" + config.address.host + "]" : config.address.host;
    is_loopback = endpoint.address().is_loopback();
    authority = fmt::format("{}:{}", host, port);
    accept();
    thread = std::thread([this] { io.run(); });
  }

  /// Says to every page that the run is over, and waits a moment for those that do not answer.
  ~Implementation() {
    asio::post(io, [this] {
      error_code ignored;
      over = true;
      acceptor.close(ignored);
      pause.expires_after(longest_goodbye);
      pause.async_wait([this](error_code) { io.stop(); });
      close_all();
    });
    thread.join();
    streams.clear();
  }

  void accept();
  void close_all();

  /// Whether the page is asked for under this server's own name. A page of elsewhere whose name was made to lead here
  /// (DNS rebinding) asks under another one.
  [[nodiscard]] bool is_own(std::string_view host) const {
    if (!is_loopback) return !host.empty();
    return host == authority || host == fmt::format("localhost:{}", port);
  }

  Config config;
  std::size_t connections = 0;  // these three in the thread of io alone
  std::set<std::shared_ptr<Client>> streams;
  bool over = false;
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer pause;
  std::string token;
  std::uint16_t port = 0;
  std::string authority;
  bool is_loopback = true;
  std::atomic<std::size_t> stream_count = 0;
  std::atomic<std::uint64_t> dropped = 0;
  std::atomic<std::uint64_t> stops = 0;
  std::atomic<bool> publishing = false;
  std::mutex greeting_mutex;
  Message greeting;
  std::thread thread;
};

/// One connection, in the thread of the server's io_context.
class LiveServer::Implementation::Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Implementation& server, tcp::socket socket) : server_(server), stream_(std::move(socket)) {
    ++server_.connections;
    parser_.header_limit(longest_header);
    parser_.body_limit(0);
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() { --server_.connections; }

  void start() {
    stream_.expires_after(longest_request);
    http::async_read(stream_, buffer_, parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (!error) self->answer();
    });
  }

  void close() {
    socket_->async_close(websocket::close_code::normal,
                         [self = shared_from_this()](error_code) { self->end(); });
  }

  void send(const Message& message) {
    if (writing_) {
      if (next_ != nullptr) ++server_.dropped;
      next_ = message;
      return;
    }
    write(message);
  }

 private:
  void answer() {
    const auto& request = parser_.get();
    const auto [path, token] = parts_of(view_of(request.target()));
    const std::string_view host = view_of(request[http::field::host]);
    if (!server_.is_own(host))
      return refuse(http::status::misdirected_request, "another host is served here\n");
    if (!is_same(token, server_.token))
      return refuse(http::status::forbidden, "the link has no valid token\n");
    if (websocket::is_upgrade(request)) {
      if (path != "/stream") return refuse(http::status::not_found, "there is one stream: /stream\n");
      if (view_of(request[http::field::origin]) != "http://" + std::string(host))
        return refuse(http::status::forbidden, "the page is from elsewhere\n");
      return open_stream();
    }
    if (request.method() != http::verb::get) return refuse(http::status::method_not_allowed, "GET alone\n");
    if (path != "/") return refuse(http::status::not_found, "there is one page: /\n");
    respond(http::status::ok, "text/html; charset=utf-8", server_.config.page, host);
  }

  void refuse(http::status status, const std::string& text) { respond(status, "text/plain", text, {}); }

  void respond(http::status status, const char* type, const std::string& text, std::string_view host) {
    response_.result(status);
    response_.set(http::field::content_type, type);
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("X-Frame-Options", "DENY");
    response_.set(
        "Content-Security-Policy",
        fmt::format(
            "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: "
            "blob:; connect-src 'self' ws://{}; frame-ancestors 'none'",
            host));
    response_.keep_alive(false);
    response_.body() = text;
    response_.prepare_payload();
    stream_.expires_after(longest_request);
    http::async_write(stream_, response_, [self = shared_from_this()](error_code, std::size_t) {
      error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  void open_stream() {
    stream_.expires_never();
    socket_.emplace(std::move(stream_));
    websocket::stream_base::timeout timeout;
    timeout.handshake_timeout = longest_request;
    timeout.idle_timeout = longest_silence;
    timeout.keep_alive_pings = true;
    socket_->set_option(timeout);
    socket_->read_message_max(longest_message);
    socket_->async_accept(parser_.get(), [self = shared_from_this()](error_code error) {
      if (!error) self->opened();
    });
  }

  void opened() {
    socket_->binary(true);
    server_.streams.insert(shared_from_this());
    server_.stream_count = server_.streams.size();
    {
      const std::lock_guard lock(server_.greeting_mutex);
      if (server_.greeting != nullptr) send(server_.greeting);
    }
    read();
  }

  void read() {
    buffer_.clear();
    socket_->async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error || !self->take()) return self->end();
      self->read();
    });
  }

  /// A message of the client. Returns false for one that sends what nobody asked for.
  bool take() {
    const auto now = std::chrono::steady_clock::now();
    if (now - second_ > std::chrono::seconds(1)) {
      second_ = now;
      messages_ = 0;
    }
    if (++messages_ > most_messages_per_s || !socket_->got_text() || !server_.config.stop) return false;
    if (beast::buffers_to_string(buffer_.data()) != stop_message) return false;
    server_.config.stop();
    ++server_.stops;
    return true;
  }

  void write(Message message) {
    writing_ = true;
    sent_ = std::move(message);
    socket_->async_write(asio::buffer(*sent_), [self = shared_from_this()](error_code error, std::size_t) {
      self->writing_ = false;
      self->sent_.reset();
      if (error) return self->end();
      if (self->next_ != nullptr) self->write(std::exchange(self->next_, nullptr));
    });
  }

  void end() {
    server_.streams.erase(shared_from_this());
    server_.stream_count = server_.streams.size();
    next_.reset();
    error_code ignored;
    beast::get_lowest_layer(*socket_).socket().close(ignored);
    if (server_.over && server_.streams.empty()) server_.io.stop();
  }

  Implementation& server_;
  beast::tcp_stream stream_;
  beast::flat_static_buffer<longest_header + longest_message> buffer_;
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
  std::optional<websocket::stream<beast::tcp_stream>> socket_;
  bool writing_ = false;
  Message sent_;
  Message next_;
  std::chrono::steady_clock::time_point second_;
  int messages_ = 0;
};

void LiveServer::Implementation::close_all() {
  if (streams.empty()) return io.stop();
  const auto all = streams;
  for (const auto& client : all) client->close();
}

void LiveServer::Implementation::accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (over || error == asio::error::operation_aborted) return;
    if (error) {  // no file descriptor is free, for example: it stays so for a while
      pause.expires_after(pause_after_failure);
      return pause.async_wait([this](error_code) { accept(); });
    }
    if (connections < config.most_clients) {
      // Little waits in the kernel for a client that does not read.
      error_code ignored;
      socket.set_option(asio::socket_base::send_buffer_size(1 << 18), ignored);
      std::make_shared<Client>(*this, std::move(socket))->start();
    }
    accept();
  });
}

LiveServer::LiveServer(Config config)
    : implementation_(std::make_unique<Implementation>(std::move(config))) {}
LiveServer::~LiveServer() = default;

std::string LiveServer::link() const {
  return fmt::format("http://{}/?token={}", implementation_->authority, implementation_->token);
}
std::uint16_t LiveServer::port() const { return implementation_->port; }
const std::string& LiveServer::token() const { return implementation_->token; }
std::uint64_t LiveServer::stops() const { return implementation_->stops; }
std::size_t LiveServer::clients() const { return implementation_->stream_count; }
std::uint64_t LiveServer::dropped() const { return implementation_->dropped; }

void LiveServer::set_greeting(std::string message) {
  const std::lock_guard lock(implementation_->greeting_mutex);
  implementation_->greeting = std::make_shared<const std::string>(std::move(message));
}

void LiveServer::publish(std::string message) {
  Implementation& server = *implementation_;
  if (server.publishing.exchange(true)) {
    ++server.dropped;
    return;
  }
  asio::post(server.io, [&server, shared = std::make_shared<const std::string>(std::move(message))] {
    server.publishing = false;
    // A client that fails ends itself later, in a handler of its own.
    for (const auto& client : server.streams) client->send(shared);
  });
}

}  // namespace saccade
