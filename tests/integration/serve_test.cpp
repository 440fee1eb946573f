// `saccade serve` as any YARP program meets it: clients of YARP alone, the simulated robot in a process of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <yarp/dev/ControlBoardVocabs.h>
#include <yarp/dev/IAxisInfo.h>
#include <yarp/dev/IControlLimits.h>
#include <yarp/dev/IControlMode.h>
#include <yarp/dev/IEncodersTimed.h>
#include <yarp/dev/IPositionControl.h>
#include <yarp/dev/IPositionDirect.h>
#include <yarp/dev/IVelocityControl.h>
#include <yarp/dev/PolyDriver.h>
#include <yarp/os/Bottle.h>
#include <yarp/os/ConnectionReader.h>
#include <yarp/os/Port.h>
#include <yarp/os/PortReader.h>
#include <yarp/os/Property.h>
#include <yarp/os/RpcClient.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <utility>

#include "recording/address_event.h"
#include "recording/event_file.h"
#include "robot/event_packet.h"
#include "session/real_time.h"
#include "tests/robot/yarp/yarp_world.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using Degrees = std::array<double, 6>;

/// A served robot. Its world is a ball that rests.
class Served {
 public:
  explicit Served(std::vector<std::string> options = {}, double duration_s = 60.0)
      : folder_(YarpWorld::get() / ("served" + std::to_string(++count_))), options_(std::move(options)) {
    options_.insert(options_.begin(),
                    {SACCADE_BINARY, "serve", SACCADE_SOURCE_DIR "/scenarios/look_at_ball.yaml", "--force",
                     "--out", folder_.string(), "--set", "run.duration_s=" + std::to_string(duration_s),
                     "--set", "render.supersampling=1", "--set", "run.threads=1"});
    start();
  }
  void start() {
    process_.emplace(options_, log());
    EXPECT_TRUE(eventually(20.0, [this] { return text_of(log()).find("are open") != std::string::npos; }))
        << text_of(log());
  }
  void kill() {
    process_.reset();
    std::filesystem::remove(log());
  }
  /// Ctrl-C.
  void interrupt() { process_->send_signal(SIGINT); }
  /// Its exit status.
  int wait() { return process_->wait(); }
  /// Not by its exit status, which YARP's ports of this process take.
  [[nodiscard]] bool is_running() const {
    const std::string stat = text_of("/proc/" + std::to_string(process_->pid()) + "/stat");
    return !stat.empty() && stat.find(") Z ") == std::string::npos;
  }
  /// The real-time priorities of its threads, 0 for none.
  [[nodiscard]] std::vector<int> priorities() const {
    std::vector<int> found;
    for (const auto& entry :
         std::filesystem::directory_iterator("/proc/" + std::to_string(process_->pid()) + "/task")) {
      const int thread = std::stoi(entry.path().filename().string());
      sched_param priority{};
      const bool is_real_time =
          ::sched_getscheduler(thread) == SCHED_FIFO && ::sched_getparam(thread, &priority) == 0;
      found.push_back(is_real_time ? priority.sched_priority : 0);
    }
    return found;
  }
  /// How many threads it has.
  [[nodiscard]] int threads() const {
    std::istringstream status(text_of("/proc/" + std::to_string(process_->pid()) + "/status"));
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with("Threads:")) return std::stoi(line.substr(8));
    }
    return 0;
  }
  [[nodiscard]] bool has_ended() const {
    return eventually(20.0, [this] { return std::filesystem::exists(folder_ / "report.html"); });
  }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::string said() const { return text_of(log()); }

 private:
  static std::string text_of(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::filesystem::path log() const { return folder_.string() + ".log"; }

  static inline int count_ = 0;
  std::filesystem::path folder_;
  std::vector<std::string> options_;
  std::optional<Child> process_;
};

/// The head as a program of YARP's has it.
struct Head {
  explicit Head(const std::string& part = "/icub/head") {
    yarp::os::Property options;
    options.put("device", yarp::os::Value("remote_controlboard"));
    options.put("remote", yarp::os::Value(part));
    options.put("local", yarp::os::Value("/client" + part));
    EXPECT_TRUE(driver.open(options) && driver.view(modes) && driver.view(encoders) && driver.view(moves) &&
                driver.view(references) && driver.view(velocities) && driver.view(limits) &&
                driver.view(axes));
    EXPECT_TRUE(eventually(2.0, [this] { return encoders->getEncoders(deg.data()); }));
  }
  Degrees positions() {
    EXPECT_TRUE(encoders->getEncoders(deg.data()));
    return deg;
  }
  bool set_modes(int mode) {
    std::array<int, 6> all{};
    all.fill(mode);
    return modes->setControlModes(all.data());
  }
  /// How far from there, at most over the joints.
  double away(const Degrees& there) {
    double most = 0.0;
    const Degrees here = positions();
    for (std::size_t j = 0; j < 6; ++j) most = std::max(most, std::abs(here[j] - there[j]));
    return most;
  }

  yarp::dev::PolyDriver driver;
  yarp::dev::IControlMode* modes = nullptr;
  yarp::dev::IEncodersTimed* encoders = nullptr;
  yarp::dev::IPositionControl* moves = nullptr;
  yarp::dev::IPositionDirect* references = nullptr;
  yarp::dev::IVelocityControl* velocities = nullptr;
  yarp::dev::IControlLimits* limits = nullptr;
  yarp::dev::IAxisInfo* axes = nullptr;
  Degrees deg{};
};

/// Somebody who asks the gaze controller.
class Gaze {
 public:
  explicit Gaze(const std::string& name = "/client/gaze") {
    EXPECT_TRUE(rpc_.open(name));
    EXPECT_TRUE(yarp::os::NetworkBase::connect(name, "/iKinGazeCtrl/rpc"));
  }
  std::string ask(const std::string& request) {
    yarp::os::Bottle reply;
    yarp::os::Bottle words(request);
    rpc_.write(words, reply);
    return reply.toString();
  }
  std::vector<double> numbers(const std::string& request) {
    yarp::os::Bottle reply;
    yarp::os::Bottle words(request);
    rpc_.write(words, reply);
    std::vector<double> values;
    if (const yarp::os::Bottle* list = reply.get(1).asList()) {
      for (std::size_t i = 0; i < list->size(); ++i) values.push_back(list->get(i).asFloat64());
    } else if (reply.size() > 1) {
      values.push_back(reply.get(1).asFloat64());
    }
    return values;
  }

 private:
  yarp::os::RpcClient rpc_;
};

/// Everything that an event port sends.
class Events final : public yarp::os::PortReader {
 public:
  Events(const std::string& from, PacketFormat format) : format_(format) {
    port_.setReader(*this);
    EXPECT_TRUE(port_.open("/client/events"));
    EXPECT_TRUE(yarp::os::NetworkBase::connect(from, "/client/events", "fast_tcp"));
  }
  ~Events() override { port_.close(); }
  bool read(yarp::os::ConnectionReader& reader) override {
    if (!reader.isValid()) return false;
    std::vector<std::byte> bytes(reader.getSize());
    if (!reader.expectBlock(reinterpret_cast<char*>(bytes.data()), bytes.size())) return false;
    const std::scoped_lock lock(mutex_);
    EventPacket packet;
    EXPECT_EQ(read_packet(bytes, format_, packet), "");
    ++packets_;
    empty_ += packet.events.empty() ? 1 : 0;
    events_.insert(events_.end(), packet.events.begin(), packet.events.end());
    return true;
  }
  [[nodiscard]] std::vector<WireEvent> events() {
    const std::scoped_lock lock(mutex_);
    return events_;
  }
  [[nodiscard]] std::int64_t packets() {
    const std::scoped_lock lock(mutex_);
    return packets_;
  }
  [[nodiscard]] std::int64_t empty() {
    const std::scoped_lock lock(mutex_);
    return empty_;
  }

 private:
  PacketFormat format_;
  yarp::os::Port port_;
  std::mutex mutex_;
  std::vector<WireEvent> events_;
  std::int64_t packets_ = 0;
  std::int64_t empty_ = 0;
};

/// A connection to the socket of a port, without YARP.
class Stranger {
 public:
  explicit Stranger(const std::string& port, const std::string& bytes = {}) {
    const yarp::os::Contact contact = yarp::os::NetworkBase::queryName(port);
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(contact.getPort()));
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    send(bytes);
  }
  Stranger(Stranger&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;
  ~Stranger() { ::close(socket_); }

  void send(const std::string& bytes) const {
    (void)!::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  /// Whether the other side closes it, however much it sends before.
  [[nodiscard]] bool is_closed_within(double timeout_s) const {
    return eventually(timeout_s, [this] {
      std::array<char, 1024> bytes;
      const ssize_t count = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
      return count == 0 || (count < 0 && errno != EAGAIN);
    });
  }

 private:
  int socket_;
};

std::string integer(std::int32_t value) {
  std::string bytes(sizeof(value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(value));
  return bytes;
}

/// An administrative message to a port, of a client that has introduced itself.
std::string administrative(const std::string& bottle) {
  const std::string payload = integer(0) + std::string("~a\0\1", 4) + bottle;
  return "YA" + integer(7777 + 3 + 128) + "RP" + integer(6) + std::string("admin\0", 6) + "YA" + integer(10) +
         "RP" + "\x01\x01" + std::string(8, '\xff') + integer(static_cast<std::int32_t>(payload.size())) +
         integer(0) + payload;
}

class Serve : public testing::Test {
 protected:
  static void SetUpTestSuite() { YarpWorld::get(); }
};

TEST_F(Serve, IsAHeadThatAProgramOfYarpMoves) {
  Served served;
  Head head;
  int axes = 0;
  ASSERT_TRUE(head.axes->getAxes(&axes));
  ASSERT_EQ(axes, 6);
  std::string name;
  EXPECT_TRUE(head.axes->getAxisName(5, name));
  EXPECT_EQ(name, "eyes_vergence");
  double min_deg = 0.0;
  double max_deg = 0.0;
  ASSERT_TRUE(head.limits->getLimits(0, &min_deg, &max_deg));
  EXPECT_NEAR(min_deg, -30.0, 1e-6);
  EXPECT_NEAR(max_deg, 17.0, 1e-6);

  // As after calibration it is in position mode, where a direct reference is refused.
  int mode = 0;
  EXPECT_TRUE(head.modes->getControlMode(0, &mode));
  EXPECT_EQ(mode, VOCAB_CM_POSITION);
  const Degrees start = head.positions();
  const Degrees there = {5, -3, 8, 4, -6, 9};
  head.references->setPositions(there.data());
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_LT(head.away(start), 0.3);

  ASSERT_TRUE(head.set_modes(VOCAB_CM_POSITION_DIRECT));
  head.references->setPositions(there.data());
  EXPECT_TRUE(eventually(2.0, [&] { return head.away(there) < 0.5; })) << head.away(there);
  // A reference outside of the limits goes to the limit.
  head.references->setPosition(0, 40.0);
  EXPECT_TRUE(eventually(2.0, [&] { return std::abs(head.positions()[0] - max_deg) < 0.5; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_LT(head.positions()[0], max_deg + 0.5);

  ASSERT_TRUE(head.set_modes(VOCAB_CM_POSITION));
  Degrees speeds{};
  speeds.fill(40.0);
  EXPECT_TRUE(head.moves->setRefSpeeds(speeds.data()));
  const Degrees home = {};
  EXPECT_TRUE(head.moves->positionMove(home.data()));
  bool done = true;
  EXPECT_TRUE(head.moves->checkMotionDone(&done));
  EXPECT_FALSE(done);
  EXPECT_TRUE(eventually(2.0, [&] { return head.moves->checkMotionDone(&done) && done; }));
  EXPECT_TRUE(eventually(1.0, [&] { return head.away(home) < 0.5; })) << head.away(home);

  ASSERT_TRUE(head.modes->setControlMode(2, VOCAB_CM_VELOCITY));
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(head.velocities->velocityMove(2, 20.0));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_GT(head.positions()[2], 5.0);
  // Nobody repeats it: it ends.
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  const double rest_deg = head.positions()[2];
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_NEAR(head.positions()[2], rest_deg, 0.1);

  Head torso("/icub/torso");
  EXPECT_FALSE(torso.modes->setControlMode(0, VOCAB_CM_POSITION));
}

TEST_F(Serve, IsAnEventCameraThatSendsWhatTheSimulatorMakes) {
  for (const PacketFormat format : {PacketFormat::stamped_packet, PacketFormat::vbottle}) {
    Served served(
        {"--wait-for-client", "--format", packet_format_names().at(static_cast<std::size_t>(format))}, 1.0);
    Events events("/zynqGrabber/AE:o", format);
    ASSERT_TRUE(eventually(5.0, [&] { return events.packets() > 20; })) << "a world that waits is not heard";
    Gaze().ask("set Tneck 0.8");  // somebody has taken the head: the world begins
    ASSERT_TRUE(served.has_ended()) << served.said();
    EXPECT_EQ(events.empty(), 0);

    // The port sends events of the first pixel while there are no others.
    const auto is_first_pixel = [](const Event& event) { return event.x == 0 && event.y == 0; };
    std::vector<Event> recorded;
    const auto reader = open_event_file(served / "events.aedat", {});
    while (reader->read(recorded, 10'000) > 0) {
    }
    std::erase_if(recorded, is_first_pixel);
    const std::int64_t ns = tick_ns(AddressCodec::ev2);
    std::vector<Event> sent;
    for (const WireEvent& word : events.events()) {
      sent.push_back(decode_address(word.address, AddressCodec::ev2).value());
      sent.back().t_us = us_from_ticks(word.stamp, ns);
    }
    std::erase_if(sent, is_first_pixel);
    std::printf("%zu events in %lld packets\n", sent.size(), static_cast<long long>(events.packets()));
    ASSERT_GT(sent.size(), 500U);
    ASSERT_LE(sent.size(), recorded.size());
    EXPECT_LT(recorded.size() - sent.size(), 200U);  // the port closed upon the last ones
    // On the wire time goes on while the world waits for its client.
    const std::int64_t waited_us = sent[0].t_us - recorded[0].t_us;
    EXPECT_GE(waited_us, 0);
    for (std::size_t i = 0; i < sent.size(); ++i) {
      recorded[i].t_us += waited_us;
      ASSERT_EQ(sent[i], recorded[i]) << i;
    }
  }
}

TEST_F(Serve, IsAGazeControllerThatLooksWhereItIsToldTo) {
  Served served;
  Gaze gaze;
  EXPECT_EQ(gaze.ask("status"), "[ack] running");
  EXPECT_EQ(gaze.ask("set Tneck 0.8"), "[ack]");
  EXPECT_EQ(gaze.ask("look 3D (0.5 0 0.3)"), "[nack]");  // behind it
  EXPECT_EQ(gaze.ask("look 3D (-0.5 0.1 0.4)"), "[ack]");
  const auto miss_m = [&] {
    const auto x = gaze.numbers("get x");
    return x.size() == 3 ? std::hypot(x[0] + 0.5, x[1] - 0.1, x[2] - 0.4) : 1.0;
  };
  EXPECT_TRUE(eventually(5.0, [&] { return gaze.numbers("get done") == std::vector{1.0}; }));
  // 0.5 deg at 0.5 m.
  EXPECT_TRUE(eventually(2.0, [&] { return miss_m() < 0.0044; })) << miss_m();

  // By the port, and stopped on the way.
  yarp::os::Port port;
  ASSERT_TRUE(port.open("/client/xd"));
  ASSERT_TRUE(yarp::os::NetworkBase::connect("/client/xd", "/iKinGazeCtrl/xd:i"));
  yarp::os::Bottle point("-0.5 -0.2 0.4");
  port.write(point);
  ASSERT_TRUE(eventually(2.0, [&] { return miss_m() > 0.05; }));
  EXPECT_EQ(gaze.ask("stop"), "[ack]");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto there = gaze.numbers("get q");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto then = gaze.numbers("get q");
  ASSERT_EQ(there.size(), 9U);
  ASSERT_EQ(then.size(), 9U);
  for (std::size_t j = 0; j < 9; ++j) EXPECT_NEAR(there[j], then[j], 0.2) << j;
}

TEST_F(Serve, StartsAgainUnderTheSameNamesAfterItWasKilled) {
  Served served({"--endless"});
  served.kill();
  served.start();
  Gaze gaze;
  EXPECT_EQ(gaze.ask("status"), "[ack] running");
  Head head;
  ASSERT_TRUE(head.set_modes(VOCAB_CM_POSITION_DIRECT));
  const Degrees there = {3, 0, 4, 0, 5, 6};
  head.references->setPositions(there.data());
  EXPECT_TRUE(eventually(2.0, [&] { return head.away(there) < 0.5; })) << head.away(there);
  served.interrupt();
  ASSERT_TRUE(served.has_ended()) << served.said();
  EXPECT_EQ(served.wait(), 0) << "Ctrl-C ends it as planned: " << served.said();
  EXPECT_THAT(served.said(), HasSubstr("commands come for the head's joints"));
  const auto metrics = nlohmann::json::parse(std::ifstream(served / "metrics.json"));
  EXPECT_TRUE(metrics.at("gaze").at("fixation_error_deg").contains("median"));
  EXPECT_EQ(metrics.at("gaze").at("limit_violations"), 0);
}

// A busy loop in another session, and whatever else the machine does, must not delay the robot.
TEST_F(Serve, SimulatesAndSendsWithRealTimePriorityBelowDeploy) {
  sched_param wanted{};
  wanted.sched_priority = serve_ports_priority;
  bool permitted = false;
  std::thread([&] {
    permitted = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted) == 0;
  }).join();
  if (!permitted) GTEST_SKIP() << "real-time priority is not permitted here";
  Served served({"--endless"});
  EXPECT_EQ(Gaze().ask("status"), "[ack] running");
  EXPECT_TRUE(eventually(20.0, [&] {
    const std::vector<int> found = served.priorities();
    return !found.empty() && found.front() == serve_priority;
  })) << "the simulation";
  const std::vector<int> found = served.priorities();
  EXPECT_GE(std::ranges::count(found, serve_ports_priority), 10) << "threads of ports";
  EXPECT_EQ(std::ranges::count(found, 0), 0) << "ordinary threads, which can hold what the others wait for";
  EXPECT_LT(std::ranges::max(found), deploy_priority);
  EXPECT_THAT(served.said(), HasSubstr("real-time priority"));
}

constexpr const char* ports[] = {"/zynqGrabber/AE:o",  "/icub/head/rpc:i",      "/icub/head/command:i",
                                 "/icub/head/state:o", "/icub/head/stateExt:o", "/iKinGazeCtrl/rpc",
                                 "/iKinGazeCtrl/xd:i"};

TEST_F(Serve, SurvivesMessagesToTheAdministrationOfItsPortsWithFalseLengths) {
  Served served({"--endless"});
  constexpr std::int32_t list = 256, text = 4;
  for (const char* port : ports) {
    for (const std::int32_t length : {-1, -0x7fffffff, 0x7fffffff}) {
      const Stranger admin(port,
                           administrative(integer(list) + integer(1) + integer(text) + integer(length)));
      EXPECT_TRUE(admin.is_closed_within(20.0)) << port;
    }
    const Stranger deep(port, "CONNECT /deep\nd\n" + std::string(60'000, '(') + "\n");
    EXPECT_TRUE(deep.is_closed_within(20.0)) << port;
    ASSERT_TRUE(served.is_running()) << port << " " << served.said();
  }
  EXPECT_EQ(Gaze().ask("status"), "[ack] running");
}

TEST_F(Serve, HasNoThreadForConnectionsThatDoNotIntroduceThemselves) {
  Served served({"--endless"});
  Gaze gaze;
  EXPECT_EQ(gaze.ask("status"), "[ack] running");
  const int before = served.threads();
  std::vector<Stranger> strangers;
  for (int i = 0; i < 40; ++i) {
    for (const char* port : ports) {
      strangers.emplace_back(port);
      strangers.emplace_back(port, "CONNECT /half");
      strangers.emplace_back(port, std::string(500, '\x7f'));
    }
  }
  EXPECT_EQ(gaze.ask("status"), "[ack] running");
  EXPECT_LE(served.threads(), before + 20) << strangers.size() << " connections";
  for (const Stranger& stranger : strangers) EXPECT_TRUE(stranger.is_closed_within(30.0));
  EXPECT_EQ(gaze.ask("status"), "[ack] running") << "a client stays connected";
  EXPECT_EQ(Gaze("/another/gaze").ask("status"), "[ack] running") << "and others can connect";
}

TEST_F(Serve, EndsBesideClientsThatAreHalted) {
  Served served({"--endless"});
  Child reader({SACCADE_YARP_PEER, "reader", "/halted", "/zynqGrabber/AE:o", "/icub/head/state:o",
                "/icub/head/stateExt:o", "/iKinGazeCtrl/q:o"},
               served / "../reader.log");
  EXPECT_TRUE(eventually(20.0, [&] { return served.said().find("has 1 reader") != std::string::npos; }))
      << served.said();
  const Stranger half("/icub/head/rpc:i", "CONNECT /half\nd\n[get] [en");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  reader.send_signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // what is sent to it fills buffers
  served.interrupt();
  EXPECT_TRUE(eventually(30.0, [&] { return !served.is_running(); })) << served.said();
  EXPECT_TRUE(served.has_ended());
}

}  // namespace
}  // namespace saccade
