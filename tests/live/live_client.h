#pragma once

#include <memory>
#include <string>
#include <utility>

// After <utility>, which Boost 1.74 does not include.
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include "apps/live/live_server.h"

namespace saccade {

using LiveStream = boost::beast::websocket::stream<boost::asio::ip::tcp::socket>;

/// "127.0.0.1:PORT", under which a server on loopback is asked.
inline std::string host_of(const LiveServer& server) { return "127.0.0.1:" + std::to_string(server.port()); }

inline boost::asio::ip::tcp::socket connected_to(const std::string& port, boost::asio::io_context& io) {
  boost::asio::ip::tcp::socket socket(io);
  socket.connect({boost::asio::ip::make_address("127.0.0.1"), static_cast<std::uint16_t>(std::stoi(port))});
  return socket;
}

/// The stream as the server's own page opens it. `link`: of the server.
inline std::unique_ptr<LiveStream> opened_stream(const std::string& link, boost::asio::io_context& io) {
  const std::string host = link.substr(7, link.find('/', 7) - 7);
  auto stream = std::make_unique<LiveStream>(connected_to(host.substr(host.find(':') + 1), io));
  stream->set_option(
      boost::beast::websocket::stream_base::decorator([host](boost::beast::websocket::request_type& request) {
        request.set(boost::beast::http::field::origin, "http://" + host);
      }));
  stream->handshake(host, "/stream" + link.substr(link.find('?')));
  return stream;
}

inline std::string next_message(LiveStream& stream) {
  boost::beast::flat_buffer buffer;
  stream.read(buffer);
  return boost::beast::buffers_to_string(buffer.data());
}

}  // namespace saccade
