// A robot in a program of its own: its frames, and the backend that speaks them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <thread>

#include "core/error.h"
#include "core/random.h"
#include "external/external_robot.h"
#include "external/robot_frames.h"
#include "external/robot_server.h"
#include "external/socket_address.h"
#include "head/head_model.h"
#include "robot/head_limits.h"
#include "robot/steady_clock.h"
#include "tests/recording/temp_folder.h"
#include "tests/robot/port_conformance.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

std::span<const std::byte> payload_of(const std::vector<std::byte>& frame) {
  return std::span(frame).subspan(frame_head_bytes);
}

RobotHello iCub_hello() {
  RobotHello hello;
  hello.image_size = {128, 128};
  hello.watchdog_ms = 60;
  for (const HeadJoint& joint : default_head()->joints) {
    if (joint.role != JointRole::torso)
      hello.joints.push_back({joint.name, joint.min_rad, joint.max_rad, joint.max_speed_rad_s});
  }
  return hello;
}

RobotContext iCub_context() {
  HeadLimitsConfig limits;
  return {joint_limits(limits), {128, 128}, {}};
}

/// A robot in a thread: a head with a lag of 30 ms, and a camera with an event every 0.5 ms.
class ThreadRobot {
 public:
  explicit ThreadRobot(const std::string& path)
      : server_(SocketAddress{path, {}, {}}, iCub_hello()), thread_([this] { run(); }) {}
  ~ThreadRobot() {
    over_ = true;
    thread_.join();
  }
  ThreadRobot(const ThreadRobot&) = delete;
  ThreadRobot& operator=(const ThreadRobot&) = delete;
  [[nodiscard]] bool follows() const { return follows_; }
  [[nodiscard]] std::int64_t clients() const { return clients_; }
  std::atomic<bool> silent = false;

 private:
  void run() {
    HeadJointVector position_rad = HeadJointVector::Zero(), reference_rad = position_rad;
    const SteadyClock clock;
    std::int64_t before_us = 5'000'000;
    while (!over_) {
      const std::int64_t t_us = 5'000'000 + clock.now_us();
      const RobotServer::Wants wants = server_.receive();
      if (wants.hold) reference_rad = position_rad;
      if (wants.reference_rad) reference_rad = HeadJointVector(wants.reference_rad->data());
      position_rad += (reference_rad - position_rad) *
                      (1.0 - std::exp(-1e-3 * static_cast<double>(t_us - before_us) / 30.0));
      before_us = t_us;
      const std::array<Event, 2> events = {
          Event{t_us - 500, 3, 4, true, 0},
          Event{t_us, static_cast<std::uint16_t>(t_us / 1000 % 128), 9, false, 0}};
      JointsFrame joints;
      joints.t_us = t_us;
      joints.count = head_joint_count;
      std::copy_n(position_rad.data(), joints.count, joints.position_rad.begin());
      follows_ = server_.follows();  // before it is sent: a client that is told finds it here
      clients_ = server_.clients();
      if (!silent) server_.send(t_us, events, joints);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  RobotServer server_;
  std::atomic<bool> over_ = false, follows_ = false;
  std::atomic<std::int64_t> clients_ = 0;
  std::thread thread_;
};

/// A robot and its backend, connected over a socket in a folder of their own.
struct Connected {
  TempFolder folder;
  ThreadRobot program{(folder / "robot").string()};
  ExternalRobot robot{ExternalRobotConfig{(folder / "robot").string()}, iCub_context()};
};

template <class Holds>
bool eventually_holds(const Holds& holds) {
  for (int i = 0; i < 5000 && !holds(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return holds();
}

PortBackend external_backend() {
  PortBackend backend;
  backend.name = "External";
  backend.make = [] {
    auto connected = std::make_shared<Connected>();
    (void)connected->robot.check();
    connected->robot.activate();
    ExternalRobot& robot = connected->robot;
    return RobotUnderTest{connected, &robot.clock(), &robot.events(), robot.head()};
  };
  // The camera's thread may be held up on a loaded machine; each event still comes at most once and in order.
  backend.lateness_us = 1'000'000;
  backend.is_real_time = true;
  return backend;
}

INSTANTIATE_TEST_SUITE_P(External, PortConformance, testing::Values(external_backend()), name_of_backend);

TEST(RobotFrames, ReadBackWhatWasWritten) {
  std::vector<std::byte> frame;
  RobotHello hello = iCub_hello();
  hello.has_imu = true;
  hello.now_us = 77;
  write_hello(hello, frame);
  RobotHello read;
  ASSERT_THAT(read_hello(payload_of(frame), read), IsEmpty());
  EXPECT_EQ(read.image_size, hello.image_size);
  EXPECT_EQ(read.watchdog_ms, 60);
  EXPECT_EQ(read.now_us, 77);
  EXPECT_TRUE(read.has_imu);
  ASSERT_EQ(read.joints.size(), 6u);
  EXPECT_EQ(read.joints[5].name, "eyes_vergence");
  EXPECT_EQ(read.joints[0].max_rad, hello.joints[0].max_rad);

  const std::vector<Event> events = {{-5, 1, 2, true, 0}, {7, 127, 0, false, 1}};
  frame.clear();
  write_events(9, events, frame);
  std::int64_t until_us = 0;
  std::vector<Event> read_back;
  ASSERT_THAT(read_events(payload_of(frame), until_us, read_back), IsEmpty());
  EXPECT_EQ(until_us, 9);
  EXPECT_EQ(read_back, events);
}

TEST(RobotFrames, AHelloOfAnotherVersionNamesBoth) {
  std::vector<std::byte> frame;
  write_hello(iCub_hello(), frame);
  frame[frame_head_bytes + 8] = std::byte{2};
  RobotHello read;
  EXPECT_EQ(read_hello(payload_of(frame), read), "hello: version of the protocol: found 2, expected 1");
}

TEST(RobotFrames, EveryCutAndEveryChangedByteOfAStreamIsReadOrNamed) {
  std::vector<std::byte> stream;
  write_hello(iCub_hello(), stream);
  const std::array<Event, 1> event = {Event{1, 2, 3, true, 0}};
  write_events(1, event, stream);
  JointsFrame joints;
  joints.count = head_joint_count;
  write_joints(joints, stream);
  const RandomStream random(1, "robot frames");
  for (std::size_t at = 0; at < stream.size(); ++at) {
    std::vector<std::byte> changed = stream;
    changed[at] = static_cast<std::byte>(random.bits(0, at));
    FrameReader reader;
    const std::span<std::byte> room = reader.room();
    std::memcpy(room.data(), changed.data(), changed.size());
    reader.received(changed.size());
    std::size_t frames = 0;
    while (const auto frame = reader.next()) {
      ++frames;
      RobotHello hello;
      JointsFrame read;
      std::int64_t until_us = 0;
      std::vector<Event> events;
      (void)read_hello(frame->payload, hello);
      EXPECT_LE(hello.joints.size(), static_cast<std::size_t>(joint_slots));
      (void)read_joints(frame->payload, head_joint_count, read);
      (void)read_events(frame->payload, until_us, events);
      EXPECT_LE(16 * events.size(), frame->payload.size());
    }
    EXPECT_LE(frames, stream.size() / frame_head_bytes);
  }
}

TEST(ExternalRobot, TheHeadHoldsWhenItsClientIsGone) {
  TempFolder folder;
  ThreadRobot program((folder / "robot").string());
  {
    ExternalRobot robot(ExternalRobotConfig{(folder / "robot").string()}, iCub_context());
    EXPECT_NO_THROW(robot.activate());  // else the robot did not say that its joints follow
  }
  EXPECT_TRUE(eventually_holds([&] { return !program.follows(); }));
}

TEST(ExternalRobot, TheRobotsWatchdogHoldsTheHeadOfAClientWithoutTicks) {
  Connected connected;
  ASSERT_NO_THROW(connected.robot.activate());
  // No tick from here on, so no heartbeat.
  EXPECT_TRUE(eventually_holds([&] { return !connected.program.follows(); }));
  EXPECT_EQ(connected.program.clients(), 1) << "the connection stays";
  EXPECT_TRUE(eventually_holds([&] {
    return connected.robot.head()->drives().joints[0] == JointDrive::held;
  })) << "deploy sees a joint that another program took";
}

TEST(ExternalRobot, AGuardStopsTheHeadAndLaterReferencesHaveNoEffect) {
  Connected connected;
  ExternalHeadStopper guard(ExternalRobotConfig{(connected.folder / "robot").string()}, iCub_context());
  connected.robot.activate();
  ASSERT_TRUE(eventually_holds([&] {
    (void)connected.robot.clock().wait_until(connected.robot.clock().now_us() +
                                             1000);  // else its watchdog stops the head
    return guard.is_connected();
  }));
  ASSERT_TRUE(eventually_holds([&] { return guard.stop(); }));
  EXPECT_FALSE(connected.program.follows());
  (void)connected.robot.head()->command(HeadCommand::Zero());
  (void)connected.robot.clock().wait_until(connected.robot.clock().now_us() + 20'000);
  EXPECT_FALSE(connected.program.follows());
  connected.robot.release();
  EXPECT_NO_THROW(connected.robot.activate()) << "an operator may activate it again";
}

TEST(ExternalRobot, AHaltReleasesTheHead) {
  Connected connected;
  connected.robot.activate();
  connected.robot.halt();
  EXPECT_TRUE(eventually_holds([&] { return !connected.program.follows(); }));
  EXPECT_TRUE(connected.robot.head()->command(HeadCommand::Zero()).rejected);
}

TEST(ExternalRobot, EveryPortIsLostWhenTheRobotsProgramEnds) {
  TempFolder folder;
  auto program = std::make_unique<ThreadRobot>((folder / "robot").string());
  ExternalRobot robot(ExternalRobotConfig{(folder / "robot").string()}, iCub_context());
  program.reset();
  EXPECT_TRUE(eventually_holds(
      [&] { return robot.clock().wait_until(robot.clock().now_us() + 1000) == PortStatus::lost; }));
  std::vector<Event> events;
  EXPECT_EQ(robot.events().read_until(robot.clock().now_us(), events), PortStatus::lost);
  HeadState state;
  EXPECT_EQ(robot.head()->read(state), PortStatus::lost);
  const std::vector<std::string> news = robot.news();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_THAT(news[0], HasSubstr("closed the connection"));
}

TEST(ExternalRobot, AnUnreadableFrameClosesTheConnectionSoThatTheRobotHolds) {
  const TempFolder folder;
  const std::string path = (folder / "robot").string();
  const int listening = listen_on(SocketAddress{path, {}, {}}, 1);
  std::atomic<bool> closed = false;
  std::thread program([&] {
    pollfd connects{listening, POLLIN, 0};
    if (::poll(&connects, 1, 5000) <= 0) return;
    const int client = ::accept(listening, nullptr, nullptr);
    std::vector<std::byte> out;
    write_hello(iCub_hello(), out);
    write_number(static_cast<RobotFrame>(77), 1, out);
    (void)::send(client, out.data(), out.size(), MSG_NOSIGNAL);
    std::array<char, 64> received{};
    pollfd more{client, POLLIN, 0};
    while (::poll(&more, 1, 5000) > 0 && !closed)
      closed = ::recv(client, received.data(), received.size(), 0) <= 0;
    ::close(client);
  });
  const ExternalRobot robot(ExternalRobotConfig{path}, iCub_context());
  EXPECT_TRUE(eventually_holds([&] { return closed.load(); }));
  program.join();
  ::close(listening);
}

TEST(ExternalRobot, AnotherHeadOrImageIsRefusedByName) {
  TempFolder folder;
  const ThreadRobot program((folder / "robot").string());
  const ExternalRobotConfig config{(folder / "robot").string()};
  RobotContext context = iCub_context();
  context.image_size = {64, 64};
  EXPECT_THROW(ExternalRobot(config, context), InputError);
  context = iCub_context();
  context.limits.head = head_of_names({"pan", "tilt"});
  try {
    const ExternalRobot robot(config, context);
    FAIL() << "it was accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("neck_pitch, neck_roll"));
    EXPECT_THAT(error.what(), HasSubstr("pan, tilt"));
  }
}

TEST(RobotServer, DisconnectsGarbageAndServesTheOthers) {
  Connected connected;
  connected.robot.activate();
  const SocketAddress address{(connected.folder / "robot").string(), {}, {}};
  const RandomStream random(2, "garbage");
  for (std::uint64_t i = 0; i < 100; ++i) {
    const int socket = connect_to(address, std::chrono::seconds(5));
    std::array<std::uint64_t, 32> garbage{};
    for (std::size_t k = 0; k < garbage.size(); ++k) garbage[k] = random.bits(i, k);
    (void)::send(socket, garbage.data(), sizeof garbage, MSG_NOSIGNAL);
    ::close(socket);
    (void)connected.robot.clock().wait_until(connected.robot.clock().now_us() + 2000);
  }
  EXPECT_TRUE(eventually_holds([&] {
    (void)connected.robot.clock().wait_until(connected.robot.clock().now_us() + 1000);
    return connected.program.clients() == 1;
  }));
  HeadState state;
  EXPECT_EQ(connected.robot.head()->read(state), PortStatus::ok) << "the first client is served on";
}

}  // namespace
}  // namespace saccade
