// Detectors and gaze controllers in programs that listen on a socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <thread>

#include "core/error.h"
#include "external/external_controller.h"
#include "external/external_detector.h"
#include "head/icub_cameras.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

/// Serves one connection in a thread: two lines of a start, then one line of answer to each line.
class Listener {
 public:
  /// `answers`: the first one to the start, each further one to the next line; then the connection is closed.
  Listener(int listening, std::vector<std::string> answers)
      : listening_(listening), thread_([this, answers = std::move(answers)] { serve(answers); }) {}
  ~Listener() {
    thread_.join();
    ::close(listening_);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  /// What came after the start; complete once the connection is closed.
  [[nodiscard]] const std::string& received() const { return received_; }

 private:
  void serve(const std::vector<std::string>& answers) {
    const int connection = ::accept(listening_, nullptr, nullptr);
    FILE* const file = ::fdopen(connection, "r+");
    char line[4096];
    for (std::size_t i = 0; i < answers.size(); ++i) {
      for (int lines = i == 0 ? 2 : 1; lines > 0 && std::fgets(line, sizeof line, file) != nullptr; --lines) {
        if (i > 0) received_ += line;
      }
      const std::string answer = answers[i] + "\n";
      (void)::send(connection, answer.data(), answer.size(), MSG_NOSIGNAL);
    }
    std::fclose(file);
  }

  int listening_;
  std::string received_;
  std::thread thread_;
};

int listen_at(const std::filesystem::path& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::ranges::copy(path.string(), name.sun_path);
  const int listening = ::socket(AF_UNIX, SOCK_STREAM, 0);
  EXPECT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  EXPECT_EQ(::listen(listening, 4), 0);
  return listening;
}

/// Listens on a free port of this machine. Returns the socket and `localhost:PORT`.
std::pair<int, std::string> listen_on_tcp() {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int listening = ::socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  EXPECT_EQ(::listen(listening, 4), 0);
  socklen_t bytes = sizeof name;
  EXPECT_EQ(::getsockname(listening, reinterpret_cast<sockaddr*>(&name), &bytes), 0);
  return {listening, "127.0.0.1:" + std::to_string(ntohs(name.sin_port))};
}

std::unique_ptr<ExternalDetector> detector_at(const std::string& address) {
  SocketConfig config;
  config.socket = address;
  config.limits = {5.0, 0.3};
  return std::make_unique<ExternalDetector>("mine", address_of(config), config.limits, icub_left_2016);
}

Estimate estimate_at(Detector& detector, std::int64_t t_us) {
  detector.advance_to(t_us, nullptr);
  return detector.estimate();
}

TEST(ExternalSocket, ADetectorAnswersOverTcp) {
  const auto [listening, address] = listen_on_tcp();
  const Listener listener(listening, {"ready 0.25", "circle 1 2 3 0.5", "none"});
  const auto detector = detector_at(address);
  EXPECT_EQ(detector->threshold(), 0.25);
  EXPECT_EQ(estimate_at(*detector, 1'000).circle.x_px, 1.0);
  EXPECT_FALSE(estimate_at(*detector, 2'000).valid);
  EXPECT_THAT(std::string(detector->failure()), IsEmpty());
}

TEST(ExternalSocket, ADetectorAnswersOverAUnixSocket) {
  const TempFolder folder;
  const std::string path = (folder / "mine.sock").string();
  std::string received;
  {
    const Listener listener(listen_at(path), {"ready 0.25", "circle 1 2 3 0.5"});
    {
      const auto detector = detector_at(path);
      EXPECT_TRUE(estimate_at(*detector, 1'000).valid);
    }
    received = listener.received();
  }
  EXPECT_EQ(received, "tick 1000 0\n");
}

TEST(ExternalSocket, AClosedConnectionEndsTheDetectorAndIsReported) {
  const auto [listening, address] = listen_on_tcp();
  const Listener listener(listening, {"ready 0.25", "circle 1 2 3 0.5"});
  const auto detector = detector_at(address);
  EXPECT_TRUE(estimate_at(*detector, 1'000).valid);
  EXPECT_FALSE(estimate_at(*detector, 2'000).valid);
  EXPECT_FALSE(estimate_at(*detector, 3'000).valid);
  EXPECT_EQ(std::string(detector->failure()),
            "mine ended at 0.002 s, its connection to " + address + " is closed");
}

TEST(ExternalSocket, NobodyThatListensIsAnErrorOnceTheTimeLimitIsOver) {
  const auto [listening, address] = listen_on_tcp();
  ::close(listening);
  SocketConfig config;
  config.socket = address;
  config.limits.start_limit_s = 0.2;
  EXPECT_THAT([&] { ExternalDetector("mine", address_of(config), config.limits, icub_left_2016); },
              ThrowsMessage<RunError>(HasSubstr("no connection to " + address + " within 200 ms")));
}

TEST(ExternalSocket, AGazeControllerAnswersOverASocket) {
  const auto [listening, address] = listen_on_tcp();
  const Listener listener(listening, {"ready", "reference 0.1 0.2 0.3 0 0 0"});
  MotionLimits limits;
  limits.max_rad = limits.hardware_max_rad = HeadJointVector::Constant(0.5);
  limits.min_rad = limits.hardware_min_rad = HeadJointVector::Constant(-0.5);
  limits.speed_rad_s = HeadJointVector::Constant(2.0);
  limits.acceleration_rad_s2 = HeadJointVector::Constant(100.0);
  ExternalController controller("mine", parse_socket_address(address).value(), {5.0, 0.3}, limits);
  const HeadJointVector reference_rad = controller.step(HeadState{}, std::nullopt, 0.001);
  EXPECT_EQ(reference_rad[1], 0.2);
  (void)controller.step(HeadState{}, std::nullopt, 0.001);
  EXPECT_THAT(std::string(controller.failure()), HasSubstr("is closed"));
}

TEST(ExternalSocket, AddressesAreAHostAndAPortOrAPath) {
  EXPECT_EQ(parse_socket_address("gpu.lab:5000")->host, "gpu.lab");
  EXPECT_EQ(parse_socket_address("gpu.lab:5000")->port, "5000");
  EXPECT_EQ(parse_socket_address("[::1]:80")->host, "::1");
  EXPECT_EQ(text_of(parse_socket_address("[::1]:80").value()), "[::1]:80");
  EXPECT_EQ(parse_socket_address("./mine.sock")->path, "./mine.sock");
  for (const char* text : {"", "gpu.lab", ":5000", "gpu.lab:", "gpu.lab:0", "gpu.lab:65536", "gpu.lab:http"})
    EXPECT_FALSE(parse_socket_address(text)) << text;
}

}  // namespace
}  // namespace saccade
