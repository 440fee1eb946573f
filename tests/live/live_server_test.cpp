// The server of live pages: who gets in, and what slow, silent and hostile clients can do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/live/live_server.h"
#include "core/error.h"
#include "tests/live/live_client.h"

namespace saccade {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using testing::HasSubstr;
using testing::StartsWith;

/// Until a condition holds, a minute at most.
template <class Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 6'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Resident memory of this process, MB.
double resident_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmRSS:") continue;
    double kb = 0.0;
    status >> kb;
    return kb / 1024.0;
  }
  return 0.0;
}

class LiveServerTest : public testing::Test {
 protected:
  LiveServerTest() { server_.set_greeting("hello"); }

  [[nodiscard]] std::string host() const { return host_of(server_); }
  /// What the server answers to the bytes, until it closes the connection.
  std::string answer_to(const std::string& bytes) {
    asio::ip::tcp::socket socket = connected_to(std::to_string(server_.port()), io_);
    boost::system::error_code error;
    asio::write(socket, asio::buffer(bytes), error);
    std::string text;
    asio::read(socket, asio::dynamic_buffer(text), error);
    return text;
  }
  std::string get(const std::string& target, const std::string& host, const std::string& more = "") {
    return answer_to("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n");
  }
  [[nodiscard]] std::string upgrade(const std::string& origin) const {
    return "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
           (origin.empty() ? "" : "Origin: " + origin + "\r\n");
  }

  std::unique_ptr<LiveStream> opened() { return opened_stream(server_.link(), io_); }

  asio::io_context io_;
  std::atomic<int> stops_ = 0;
  LiveServer server_{{.address = {}, .page = "the page", .most_clients = 128, .stop = [this] { ++stops_; }}};
};

TEST(LiveAddress, IsAPortOnLoopbackUnlessAnAddressIsGiven) {
  EXPECT_EQ(live_address_of("").host, "127.0.0.1");
  EXPECT_EQ(live_address_of("8080").port, 8080);
  EXPECT_EQ(live_address_of("8080").host, "127.0.0.1");
  EXPECT_EQ(live_address_of("0.0.0.0:81").host, "0.0.0.0");
  EXPECT_EQ(live_address_of("[::1]:82").host, "::1");
  EXPECT_EQ(live_address_of("[::1]:82").port, 82);
  for (const char* const bad : {"x", "80x", "70000", "-1", "host:80", "1.2.3:80", ":80", "1.2.3.4:"})
    EXPECT_THROW((void)live_address_of(bad), InputError) << bad;
}

TEST_F(LiveServerTest, GivesThePageToTheLinkAlone) {
  EXPECT_EQ(server_.link(), "http://" + host() + "/?token=" + server_.token());
  const std::string page = get("/?token=" + server_.token(), host());
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(page, HasSubstr("the page"));
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy: default-src 'none'"));
  const std::string wrong(server_.token().size(), '0');
  for (const std::string& target :
       std::vector<std::string>{std::string("/"), "/?token=", "/?token=" + wrong,
                                "/?token=" + server_.token() + "0", "/?token=" + server_.token().substr(1)})
    EXPECT_THAT(get(target, host()), StartsWith("HTTP/1.1 403")) << target;
  EXPECT_THAT(get("/other?token=" + server_.token(), host()), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(answer_to("POST /?token=" + server_.token() + " HTTP/1.1\r\nHost: " + host() + "\r\n\r\n"),
              StartsWith("HTTP/1.1 405"));
}

TEST_F(LiveServerTest, GivesNothingUnderANameOfElsewhere) {
  const std::string port = ":" + std::to_string(server_.port());
  EXPECT_THAT(get("/?token=" + server_.token(), "localhost" + port), StartsWith("HTTP/1.1 200"));
  for (const std::string& name : std::vector<std::string>{std::string("attacker.example") + port,
                                                          std::string("127.0.0.1"), "127.0.0.2" + port})
    EXPECT_THAT(get("/?token=" + server_.token(), name), StartsWith("HTTP/1.1 421")) << name;
}

TEST_F(LiveServerTest, GivesTheStreamToItsOwnPageAlone) {
  const std::string target = "/stream?token=" + server_.token();
  for (const std::string& origin :
       std::vector<std::string>{std::string(), std::string("null"), std::string("http://attacker.example"),
                                "https://" + host(), "http://" + host() + "0"})
    EXPECT_THAT(get(target, host(), upgrade(origin)), StartsWith("HTTP/1.1 403")) << origin;
  EXPECT_THAT(get("/stream?token=0", host(), upgrade("http://" + host())), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(get("/?token=" + server_.token(), host(), upgrade("http://" + host())),
              StartsWith("HTTP/1.1 404"));
  EXPECT_EQ(server_.clients(), 0U);
  const auto stream = opened();
  EXPECT_EQ(next_message(*stream), "hello");
}

TEST_F(LiveServerTest, AHundredClientsGetTheNewestMessage) {
  std::vector<std::unique_ptr<LiveStream>> clients;
  for (int i = 0; i < 100; ++i) clients.push_back(opened());
  for (const auto& client : clients) EXPECT_EQ(next_message(*client), "hello");
  EXPECT_EQ(server_.clients(), 100U);
  server_.publish("to all");
  for (const auto& client : clients) EXPECT_EQ(next_message(*client), "to all");
}

TEST_F(LiveServerTest, ConnectionsBeyondTheBoundAreClosed) {
  std::vector<std::unique_ptr<LiveStream>> clients;
  for (int i = 0; i < 128; ++i) clients.push_back(opened());
  EXPECT_EQ(get("/?token=" + server_.token(), host()), "");
  clients.clear();
  EXPECT_TRUE(
      eventually([&] { return get("/?token=" + server_.token(), host()).starts_with("HTTP/1.1 200"); }));
}

TEST_F(LiveServerTest, ClientsThatDoNotReadNeitherHoldUpOthersNorGrowMemory) {
  std::vector<std::unique_ptr<LiveStream>> silent;
  for (int i = 0; i < 20; ++i) silent.push_back(opened());
  const auto reader = opened();
  EXPECT_EQ(next_message(*reader), "hello");
  std::atomic<bool> over = false;
  std::string last;
  std::thread reading([&] {
    while (last != "end") last = next_message(*reader);
    over = true;
  });
  constexpr std::size_t message = 1 << 20;
  const auto publish = [&](int count) {
    for (int i = 0; i < count; ++i) {
      server_.publish(std::string(message, 'x'));
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  };
  publish(50);  // what buffers and queues take at most is taken
  [[maybe_unused]] const double before_mb = resident_mb();
  publish(300);
#ifndef __SANITIZE_ADDRESS__  // it keeps freed memory
  // 20 clients that keep what they are sent would hold 6000 MB more, of one message each 20 MB.
  EXPECT_LT(resident_mb() - before_mb, 60.0);
#endif
  EXPECT_GT(server_.dropped(), 300U);
  // The one that reads gets the end.
  EXPECT_TRUE(eventually([&] {
    server_.publish("end");
    return over.load();
  }));
  reading.join();
}

TEST_F(LiveServerTest, GarbageEndsItsOwnConnectionAlone) {
  const auto good = opened();
  EXPECT_EQ(next_message(*good), "hello");
  // Before the handshake.
  for (const std::string& bytes :
       std::vector<std::string>{std::string("\x16\x03\x01\x02\x00", 5), std::string(300'000, 'A'),
                                std::string("GET / HTTP/9.9\r\n\r\n"),
                                "GET / HTTP/1.1\r\nHost: " + std::string(20'000, 'h') + "\r\n\r\n"}) {
    const std::string answer = answer_to(bytes);
    EXPECT_TRUE(answer.empty() || answer.starts_with("HTTP/1.1 4")) << answer.substr(0, 80);
  }
  // Frames: without a mask, with reserved bits, of an unknown kind, a control frame of 200 bytes, 2^62 bytes announced.
  const std::vector<std::string> frames = {
      std::string("\x81\x04stop", 6), std::string("\xf1\x80\0\0\0\0", 6), std::string("\x83\x80\0\0\0\0", 6),
      std::string("\x89\xfe\x00\xc8\0\0\0\0", 8), std::string("\x82\xff\x40\0\0\0\0\0\0\0\0\0\0\0", 14)};
  for (const std::string& frame : frames) {
    const auto hostile = opened();
    EXPECT_EQ(next_message(*hostile), "hello");
    boost::system::error_code error;
    asio::write(hostile->next_layer(), asio::buffer(frame), error);
    std::string rest;
    asio::read(hostile->next_layer(), asio::dynamic_buffer(rest), error);  // ends: the server closes
    EXPECT_LT(rest.size(), 200U);
  }
  // Messages that nobody asked for: too long, binary, another word.
  for (const auto& [text, is_text] : std::vector<std::pair<std::string, bool>>{
           std::pair(std::string(5'000, 's'), true), std::pair(std::string("stop"), false),
           std::pair(std::string("activate"), true)}) {
    const auto hostile = opened();
    hostile->text(is_text);
    beast::error_code error;
    hostile->write(asio::buffer(text), error);  // the server may close before it has all
    error.clear();
    beast::flat_buffer buffer;
    while (!error) {
      hostile->read(buffer, error);
      buffer.clear();
    }
  }
  EXPECT_EQ(stops_, 0);
  EXPECT_TRUE(eventually([&] { return server_.clients() == 1; }));
  server_.publish("still here");
  EXPECT_EQ(next_message(*good), "still here");
}

TEST_F(LiveServerTest, TakesStopAndNoFloodOfIt) {
  const auto client = opened();
  EXPECT_EQ(next_message(*client), "hello");
  client->text(true);
  client->write(asio::buffer(std::string("stop")));
  EXPECT_TRUE(eventually([&] { return stops_ == 1; }));
  beast::error_code error;
  for (int i = 0; i < 1'000 && !error; ++i) client->write(asio::buffer(std::string("stop")), error);
  EXPECT_TRUE(eventually([&] { return server_.clients() == 0; }));
  EXPECT_LT(stops_, 500);  // 20 a second
}

TEST(LiveServer, WithoutACommandTakesNone) {
  asio::io_context io;
  const LiveServer server({.address = {}, .page = ""});
  const auto stream = opened_stream(server.link(), io);
  stream->text(true);
  stream->write(asio::buffer(std::string("stop")));
  beast::flat_buffer buffer;
  beast::error_code error;
  stream->read(buffer, error);
  EXPECT_TRUE(error);
  EXPECT_EQ(server.stops(), 0U);
}

TEST(LiveServer, TellsItsPagesThatTheRunIsOver) {
  asio::io_context io;
  auto server = std::make_unique<LiveServer>(LiveServer::Config{.address = {}, .page = ""});
  std::vector<std::unique_ptr<LiveStream>> streams;
  for (int i = 0; i < 3; ++i) streams.push_back(opened_stream(server->link(), io));
  // One does not answer: the server waits for it no longer than half a second.
  std::thread ending([&] { server.reset(); });
  for (int i = 0; i < 2; ++i) {
    beast::flat_buffer buffer;
    beast::error_code error;
    streams[static_cast<std::size_t>(i)]->read(buffer, error);
    EXPECT_EQ(error, beast::websocket::error::closed);
    EXPECT_EQ(streams[static_cast<std::size_t>(i)]->reason().code, beast::websocket::close_code::normal);
  }
  ending.join();
}

TEST(LiveServer, SaysWhereItCannotListen) {
  const LiveServer server({.address = {}, .page = ""});
  try {
    const LiveServer other({.address = {.host = "127.0.0.1", .port = server.port()}, .page = ""});
    FAIL();
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("--web: 127.0.0.1:" + std::to_string(server.port()) + " cannot be used"));
  }
}

}  // namespace
}  // namespace saccade
