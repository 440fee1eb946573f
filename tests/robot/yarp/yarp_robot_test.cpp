#include "robot/yarp/yarp_robot.h"

#include <arpa/inet.h>
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <yarp/dev/ControlBoardVocabs.h>
#include <yarp/dev/IControlMode.h>
#include <yarp/dev/IEncoders.h>
#include <yarp/dev/PolyDriver.h>
#include <yarp/os/Property.h>
#include <yarp/os/RpcClient.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <thread>

#include "apps/deploy/edge_check.h"
#include "apps/deploy/guard_head.h"
#include "core/error.h"
#include "robot/yarp/checked_port.h"
#include "robot/yarp/control_board.h"
#include "robot/yarp/event_port.h"
#include "robot/yarp/port_gate.h"
#include "robot/yarp/state_input.h"
#include "robot/yarp/yarp_head.h"
#include "tests/robot/port_conformance.h"
#include "tests/robot/yarp/peers.h"
#include "tests/robot/yarp/yarp_world.h"

namespace saccade {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr double deg = 3.14159265358979323846 / 180.0;

JointLimits our_limits() {
  JointLimits limits;
  limits.min_rad.head<joint_count>() << -90, -90, -90, -30, -20, -45, -30, -30, 0;
  limits.max_rad.head<joint_count>() << 90, 90, 90, 17, 20, 45, 30, 30, 50;
  limits.min_rad *= deg;
  limits.max_rad *= deg;
  limits.max_speed_rad_s.setConstant(5.0);
  return limits;
}

/// The same reference for every joint of the iCub.
HeadCommand all_joints(double reference_rad) {
  HeadCommand reference = HeadCommand::Zero();
  reference.head<joint_count - torso_joint_count>().setConstant(reference_rad);
  return reference;
}

/// A head's control board in this process.
class Board {
 public:
  explicit Board(const std::string& part) : served_(part, robot_limits_deg) {
    EXPECT_TRUE(served_.is_open()) << "no devices controlBoard_nws_yarp and fakeMotionControl";
    yarp::os::Property client;
    client.put("device", yarp::os::Value("remote_controlboard"));
    client.put("remote", yarp::os::Value(part));
    client.put("local", yarp::os::Value("/other" + part));
    EXPECT_TRUE(client_.open(client) && client_.view(modes_) && client_.view(encoders_));
  }

  std::vector<int> modes() {
    std::vector<int> modes(6);
    EXPECT_TRUE(modes_->getControlModes(modes.data()));
    return modes;
  }
  /// Returns when everybody who is streamed the modes knows.
  void set_mode(int joint, int mode) {
    EXPECT_TRUE(modes_->setControlMode(joint, mode));
    EXPECT_TRUE(eventually(1.0, [&] { return modes().at(static_cast<std::size_t>(joint)) == mode; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  std::vector<double> positions_deg() {
    std::vector<double> positions(6);
    encoders_->getEncoders(positions.data());
    return positions;
  }

 private:
  ServedBoard served_;
  yarp::dev::PolyDriver client_;
  yarp::dev::IControlMode* modes_ = nullptr;
  yarp::dev::IEncoders* encoders_ = nullptr;
};

/// Names of its own for each robot's world, so that no test meets what another left.
std::string unique_name(const std::string& base) {
  static int count = 0;
  return base + std::to_string(++count);
}

YarpConfig config_for(const std::string& robot, const std::string& control = "joints") {
  YarpConfig config;
  config.local = "/saccade" + robot;
  config.timeout_s = 2.0;
  config.camera.port = robot + "/AE:o";
  config.head.control = control;
  config.head.part = robot + "/head";
  config.gaze_server.name = robot + "/gaze";
  return config;
}

/// A camera, a control board, and the robot connected to both.
struct JointsWorld {
  std::string name;
  CountingGrabber grabber;
  Board board;
  YarpRobot robot;

  explicit JointsWorld(std::string robot_name = unique_name("/icub"))
      : name(std::move(robot_name)),
        grabber(name + "/AE:o"),
        board(name + "/head"),
        robot(config_for(name), our_limits()) {}
};

/// A gaze controller instead of the board.
struct GazeWorld {
  std::string name = unique_name("/icub");
  CountingGrabber grabber{name + "/AE:o"};
  GazeController controller{name + "/gaze"};
  YarpRobot robot{config_for(name, "gaze"), our_limits()};
};

std::vector<StartUpCheck> failed(const std::vector<StartUpCheck>& checks) {
  std::vector<StartUpCheck> failed;
  std::copy_if(checks.begin(), checks.end(), std::back_inserter(failed),
               [](const auto& c) { return !c.passed; });
  return failed;
}

std::string text(const std::vector<StartUpCheck>& checks) {
  std::string text;
  for (const StartUpCheck& check : checks)
    text += check.what + ": " + check.found + (check.passed ? "\n" : " FAILED\n");
  return text;
}

double ms_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// Whether something takes less than a tenth of a second: on a busy machine in one of three attempts.
bool within_a_tenth_of_a_second(const std::function<double()>& attempt_ms) {
  for (int i = 0; i < 3; ++i) {
    const double ms = attempt_ms();
    std::cout << "lost after " << ms << " ms\n";
    if (ms < 100.0) return true;
  }
  return false;
}

class Yarp : public testing::Test {
 protected:
  Yarp() { YarpWorld::get(); }
};

PortBackend joints_backend() {
  PortBackend backend{
      "Yarp", [] {
        YarpWorld::get();
        const auto world = std::make_shared<JointsWorld>();
        world->robot.activate();
        return RobotUnderTest{world, &world->robot.clock(), &world->robot.events(), world->robot.head()};
      }};
  backend.is_real_time = true;
  backend.moves_instantly = true;
  backend.lateness_us = 500'000;
  return backend;
}

PortBackend gaze_backend() {
  PortBackend backend{
      "YarpGaze", [] {
        YarpWorld::get();
        const auto world = std::make_shared<GazeWorld>();
        return RobotUnderTest{world, &world->robot.clock(), &world->robot.events(), world->robot.head()};
      }};
  backend.is_real_time = true;
  backend.accepts_commands = false;
  backend.moves_as_commanded = false;
  backend.lateness_us = 500'000;
  return backend;
}

INSTANTIATE_TEST_SUITE_P(Robot, PortConformance, testing::Values(joints_backend(), gaze_backend()),
                         name_of_backend);

// ---- The camera

TEST(YarpNames, ThreadsThatResolveNamesDoNotShareTheResult) {
  // As YARP's library finds it.
  const auto resolve = reinterpret_cast<hostent* (*)(const char*)>(::dlsym(RTLD_DEFAULT, "gethostbyname"));
  const hostent* first = resolve("127.0.0.1");
  ASSERT_NE(first, nullptr);
  std::thread([&] { EXPECT_NE(resolve("127.0.0.2"), nullptr); }).join();
  in_addr address{};
  ASSERT_EQ(first->h_length, static_cast<int>(sizeof address));
  std::memcpy(&address, first->h_addr_list[0], sizeof address);
  EXPECT_STREQ(::inet_ntoa(address), "127.0.0.1");
}

TEST(YarpChildren, TheExitStatusOfAProgramIsNotLost) {
  YarpWorld::get();
  const std::string name = unique_name("/children");
  const Grabber grabber(name + "/AE:o", PacketFormat::packet);
  const YarpRobot robot(config_for(name, "none"), our_limits());
  pid_t child = 0;
  std::string program = "false";
  std::array<char*, 2> arguments = {program.data(), nullptr};
  ASSERT_EQ(::posix_spawnp(&child, "false", nullptr, nullptr, arguments.data(), environ), 0);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

/// Ends the test's program where a global object is used after its end.
struct GlobalObject {
  bool ended = false;
  GlobalObject() = default;
  GlobalObject(const GlobalObject&) = delete;
  GlobalObject& operator=(const GlobalObject&) = delete;
  ~GlobalObject() {
    ended = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  void use() const {
    if (ended) std::abort();
  }
};

TEST(YarpRequests, AProgramMayEndWhileOneHasNoAnswer) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto end_early = [] {
    static GlobalObject object;
    const bool answered = answered_within(0.02, [] {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      object.use();
      return true;
    });
    std::exit(answered ? 1 : 3);
  };
  EXPECT_EXIT(end_early(), testing::ExitedWithCode(3), "");
}

TEST(YarpHead, AProgramMayEndWhileThreadsOfYarpRun) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto end_early = [] {
    static GlobalObject object;
    std::thread([] {
      for (;;) object.use();
    }).detach();
    end_without_destructors();
    std::exit(3);
  };
  EXPECT_EXIT(end_early(), testing::ExitedWithCode(3), "");
}

TEST(PortGateQueue, ManyClientsMayWaitForASocketOnWhichYarpLetsOneWait) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(listener, 1), 0);
  const auto may_wait = [&] {
    tcp_info info{};
    socklen_t size = sizeof info;
    return ::getsockopt(listener, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 ? info.tcpi_sacked : 0;
  };
  EXPECT_EQ(may_wait(), 1u);
  std::optional<PortGate> gate(std::in_place);
  std::thread acceptor([&] { EXPECT_LT(::accept(listener, nullptr, nullptr), 0); });
  EXPECT_TRUE(eventually(20.0, [&] { return may_wait() == static_cast<unsigned>(PortGate::most_clients); }));
  ::shutdown(listener, SHUT_RDWR);
  gate.reset();
  acceptor.join();
  ::close(listener);
}

TEST_F(Yarp, EachEventOfARunningCameraIsDeliveredOnceForAnyReadInterval) {
  for (const int stride : {1, 20}) {
    JointsWorld world;
    std::vector<Event> events;
    for (int i = 1; i <= 300; ++i) {
      world.robot.clock().wait_until(world.robot.clock().now_us() + 1000);
      if (i % stride == 0) world.robot.events().read_until(world.robot.clock().now_us(), events);
    }
    ASSERT_GT(events.size(), 500u);
    std::int64_t n = events[0].x + 128 * events[0].y;
    if (counted_event(n).on != events[0].on) n += 16384;
    for (const Event& event : events) {
      const Event expected = counted_event(n++);
      ASSERT_TRUE(event.x == expected.x && event.y == expected.y && event.on == expected.on)
          << "a gap at " << n;
    }
    EXPECT_EQ(world.robot.events().traffic().dropped, 0);
  }
}

/// A camera at rest for 1.5 s; then an edge crosses its image from left to right at 100 px/s, with events of one polarity.
class EdgeGrabber {
 public:
  EdgeGrabber(const std::string& name, bool on)
      : grabber_(name, PacketFormat::packet), thread_([this, on] { run(on); }) {}

 private:
  void run(bool on) {
    for (int tick = 0; tick < 278; ++tick) {
      EventPacket packet{10'000, {}};
      const auto column = static_cast<std::uint16_t>(std::max(0, tick - 150));
      for (std::uint16_t y = 0; y < (column == 0 ? 1 : 128);
           ++y)  // at rest one event, so that the camera is not silent
        packet.events.push_back({0, encode_address({0, column, y, on, 0}, AddressCodec::ev2)});
      grabber_.send(packet);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  Grabber grabber_;
  std::jthread thread_;
};

TEST(YarpEdge, AnEdgeThatCrossesTheImageShowsThePolarityOnTheWire) {
  YarpWorld::get();
  for (const bool on : {true, false}) {
    for (const bool swapped : {false, true}) {
      const std::string name = unique_name("/edge");
      const EdgeGrabber grabber(name + "/AE:o", on);
      YarpConfig config = config_for(name, "none");
      config.camera.swap_polarity = swapped;
      YarpRobot robot(config, our_limits());
      const auto checks = edge_checks(robot, 3.0, "swap it");
      ASSERT_EQ(checks.size(), 1u);
      EXPECT_EQ(checks[0].passed, on != swapped) << checks[0].found;
      EXPECT_THAT(checks[0].found, HasSubstr(on == swapped ? "ON means darker" : "made ON at"));
    }
  }
}

class YarpWire : public testing::TestWithParam<const char*> {};

TEST_P(YarpWire, CarriesEveryEventInOrderAndAtItsTime) {
  YarpWorld::get();
  const auto& names = packet_format_names();
  const auto format =
      static_cast<PacketFormat>(std::find(names.begin(), names.end(), GetParam()) - names.begin());
  for (const char* carrier : {"tcp", "fast_tcp"}) {
    const std::string name = unique_name("/wire");
    Grabber grabber(name + "/AE:o", format);
    YarpConfig config = config_for(name, "none");
    config.camera.format = GetParam();
    config.camera.carrier = carrier;
    YarpRobot robot(config, our_limits());
    ASSERT_TRUE(eventually(2.0, [&] { return grabber.readers() == 1; }));
    std::int64_t n = 0;
    std::int64_t sent_us = 1'000'000;  // on the camera's clock
    for (int message = 0; message < 50; ++message) {
      EventPacket packet{2000, {}};
      for (int i = 0; i < 8; ++i) {
        sent_us += 250;
        packet.events.push_back({has_stamps(format) ? static_cast<std::uint32_t>(sent_us * 25 / 2) : 0,
                                 encode_address(counted_event(n++), AddressCodec::ev2)});
      }
      grabber.send(packet, 1e-6 * static_cast<double>(sent_us));
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ASSERT_TRUE(eventually(2.0, [&] { return robot.events().traffic().packets == 50; })) << carrier;
    std::vector<Event> events;
    EXPECT_EQ(robot.events().read_until(robot.clock().now_us(), events), PortStatus::ok);
    ASSERT_EQ(events.size(), static_cast<std::size_t>(n));
    int apart = 0;
    for (std::size_t i = 0; i < events.size(); ++i) {
      Event expected = counted_event(static_cast<std::int64_t>(i));
      expected.t_us = events[i].t_us;
      ASSERT_EQ(events[i], expected) << i;
      if (i > 0 && events[i].t_us - events[i - 1].t_us == 250) ++apart;
    }
    std::cout << carrier << ": " << apart << " of " << events.size() - 1 << " distances are kept\n";
    EXPECT_GT(apart, 300) << "all but those where a message with less delay came";
    EXPECT_EQ(robot.events().traffic().dropped, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Yarp, YarpWire, testing::Values("packet", "stamped_packet", "vbottle"),
                         [](const auto& wire) { return std::string(wire.param); });

TEST_F(Yarp, AnEmptyPacketUpdatesTheLastPacketTimeWithoutEvents) {
  const std::string name = unique_name("/icub");
  Grabber grabber(name + "/AE:o", PacketFormat::packet);
  YarpRobot robot(config_for(name, "none"), our_limits());
  ASSERT_TRUE(eventually(2.0, [&] { return grabber.readers() == 1; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const std::int64_t before_us = robot.clock().now_us();
  EXPECT_LT(robot.events().heard_us(), before_us);
  grabber.send({1000, {}});
  EXPECT_TRUE(eventually(1.0, [&] { return robot.events().heard_us() >= before_us; }));
  std::vector<Event> events;
  EXPECT_EQ(robot.events().read_until(robot.clock().now_us(), events), PortStatus::ok);
  EXPECT_THAT(events, IsEmpty());
}

TEST_F(Yarp, AMessageOfAnotherFormatIsReportedAndIgnored) {
  const std::string name = unique_name("/icub");
  Grabber grabber(name + "/AE:o", PacketFormat::vbottle);
  YarpRobot robot(config_for(name, "none"), our_limits());
  ASSERT_TRUE(eventually(2.0, [&] { return grabber.readers() == 1; }));
  grabber.send({0, {{1, 2}}});
  std::vector<std::string> news;
  EXPECT_TRUE(eventually(1.0, [&] { return !(news = robot.news()).empty(); }));
  EXPECT_THAT(news, ElementsAre(HasSubstr("not an ev::packet")));
  EXPECT_THAT(robot.news(), IsEmpty()) << "it is told once";
  EXPECT_EQ(robot.events().traffic().packets, 0);
  EXPECT_THAT(text(failed(robot.check())), HasSubstr("unreadable message"));
}

TEST_F(Yarp, EventsOfTwoPortsAreMergedIntoOneStream) {
  const std::string name = unique_name("/icub");
  Grabber left(name + "/AE:o", PacketFormat::packet);
  Grabber right(name + "/right:o", PacketFormat::packet);
  YarpConfig config = config_for(name, "none");
  config.camera.right_port = name + "/right:o";
  YarpRobot robot(config, our_limits());
  ASSERT_TRUE(eventually(2.0, [&] { return left.readers() == 1 && right.readers() == 1; }));
  const EventPacket packet{
      1000, std::vector<WireEvent>(10, {0, encode_address({0, 3, 4, true, 0}, AddressCodec::ev2)})};
  std::vector<Event> events;
  for (int i = 0; i < 20; ++i) {
    left.send(packet, 1.0 + 1e-3 * i);
    right.send(packet, 2.0 + 1e-3 * i);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    robot.events().read_until(robot.clock().now_us(), events);
  }
  ASSERT_TRUE(eventually(2.0, [&] { return robot.events().traffic().packets == 40; }));
  robot.events().read_until(robot.clock().now_us(), events);
  EXPECT_TRUE(std::is_sorted(events.begin(), events.end(),
                             [](const Event& a, const Event& b) { return a.t_us < b.t_us; }));
  const auto of_right =
      std::count_if(events.begin(), events.end(), [](const Event& e) { return e.camera == 1; });
  EXPECT_EQ(of_right + robot.events().traffic().dropped, 200);
  EXPECT_EQ(events.size(), 400u - static_cast<std::size_t>(robot.events().traffic().dropped));
}

// ---- The control board

TEST_F(Yarp, EveryCheckIsListed) {
  JointsWorld world;
  const std::vector<StartUpCheck> checks = world.robot.check();
  EXPECT_THAT(failed(checks), IsEmpty()) << text(checks);
  EXPECT_EQ(checks.size(), 6u) << text(checks);
  std::cout << text(checks);
}

TEST_F(Yarp, EveryMissingConnectionIsListed) {
  YarpConfig config = config_for(unique_name("/nobody"));
  config.head.torso_part = "/nobody/torso";
  YarpRobot robot(config, our_limits());
  const std::vector<StartUpCheck> checks = robot.check();
  EXPECT_EQ(failed(checks).size(), 3u) << text(checks);
  std::vector<Event> events;
  EXPECT_EQ(robot.events().read_until(0, events), PortStatus::lost);
  HeadState state;
  EXPECT_EQ(robot.head()->read(state), PortStatus::lost);
  EXPECT_THROW(robot.activate(), RunError);
}

TEST_F(Yarp, LimitsAreTheTighterOnesOfRobotAndFile) {
  JointsWorld world;
  const JointLimits limits = world.robot.head()->limits();
  EXPECT_NEAR(limits.max_rad[neck_pitch], 16 * deg, 1e-9);
  EXPECT_NEAR(limits.min_rad[eyes_vergence], 1 * deg, 1e-9);
  JointLimits tight = our_limits();
  tight.max_rad[neck_pitch] = 10 * deg;
  YarpConfig config = config_for(world.name);
  config.local = unique_name("/tight");
  YarpRobot robot(config, tight);
  EXPECT_NEAR(robot.head()->limits().max_rad[neck_pitch], 10 * deg, 1e-9);
  EXPECT_THAT(failed(robot.check()), IsEmpty())
      << "limits of one's own may be tighter: " << text(robot.check());
  EXPECT_THAT(text(world.robot.check()), HasSubstr("narrowed by the robot: neck_pitch -29 to 16"));
}

TEST_F(Yarp, ReleaseRestoresTheModesOfTheJoints) {
  JointsWorld world;
  HeadPort& head = *world.robot.head();
  const HeadCommand reference = all_joints(5 * deg);
  EXPECT_TRUE(head.command(reference).rejected) << "before activate()";
  world.board.set_mode(2, VOCAB_CM_VELOCITY);
  const std::vector<int> found = world.board.modes();
  world.robot.activate();
  EXPECT_TRUE(
      eventually(1.0, [&] { return world.board.modes() == std::vector<int>(6, VOCAB_CM_POSITION_DIRECT); }));
  EXPECT_FALSE(head.command(reference).rejected);
  HeadState state;
  EXPECT_TRUE(eventually(1.0, [&] {
    head.read(state);
    return (state.head_position_rad() - reference).norm() < 1e-6;
  }));
  EXPECT_TRUE(eventually(1.0, [&] { return std::abs(world.board.positions_deg().at(4) - 5.0) < 1e-6; }))
      << "degrees on the wire";
  EXPECT_TRUE(state.position_rad.head<torso_joint_count>().isZero());
  world.robot.release();
  world.robot.release();
  EXPECT_TRUE(eventually(1.0, [&] { return world.board.modes() == found; }));
  EXPECT_TRUE(head.command(reference).rejected) << "after release()";
  EXPECT_EQ(head.read(state), PortStatus::ok) << "joints are read throughout";
}

TEST_F(Yarp, IdleAndFaultyJointsAreNotActivated) {
  JointsWorld world;
  for (const int mode : {VOCAB_CM_IDLE, VOCAB_CM_HW_FAULT}) {
    world.board.set_mode(1, mode);
    EXPECT_THROW(world.robot.activate(), RunError);
    EXPECT_EQ(world.board.modes().at(1), mode);
    EXPECT_EQ(world.board.modes().at(0), VOCAB_CM_POSITION);
    EXPECT_THAT(text(failed(world.robot.check())), HasSubstr("joints held by their board"));
  }
}

TEST_F(Yarp, AJointThatIsSwitchedOffWhileActiveIsReportedAndStaysOff) {
  JointsWorld world;
  world.robot.activate();
  HeadPort& head = *world.robot.head();
  EXPECT_TRUE(eventually(1.0, [&] { return head.drives().joints[1] == JointDrive::references; }));
  world.board.set_mode(1, VOCAB_CM_IDLE);
  EXPECT_TRUE(eventually(1.0, [&] { return head.drives().joints[1] == JointDrive::off; }));
  EXPECT_EQ(head.drives().joints[0], JointDrive::references);
  world.board.set_mode(3, VOCAB_CM_HW_FAULT);
  EXPECT_TRUE(eventually(1.0, [&] { return head.drives().joints[3] == JointDrive::fault; }));
  world.robot.release();
  EXPECT_TRUE(eventually(1.0, [&] { return world.board.modes().at(0) == VOCAB_CM_POSITION; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(world.board.modes().at(1), VOCAB_CM_IDLE) << "release() does not switch it on";
  EXPECT_EQ(world.board.modes().at(3), VOCAB_CM_HW_FAULT);
}

TEST_F(Yarp, AHaltFromAnotherThreadStopsTheHeadUntilTheNextActivation) {
  JointsWorld world;
  world.robot.activate();
  HeadPort& head = *world.robot.head();
  const HeadCommand reference = all_joints(5 * deg);
  EXPECT_FALSE(head.command(reference).rejected);
  EXPECT_TRUE(eventually(1.0, [&] { return std::abs(world.board.positions_deg().at(4) - 5.0) < 1e-6; }));
  std::thread([&] { world.robot.halt(); }).join();
  EXPECT_TRUE(head.command(all_joints(8 * deg)).rejected);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_NEAR(world.board.positions_deg().at(4), 5.0, 1e-6);
  world.robot.release();
  world.robot.activate();
  EXPECT_FALSE(head.command(reference).rejected);
}

TEST_F(Yarp, AHeadWhoseReadingsAreLostIsStoppedAndReleased) {
  JointsWorld world;
  const std::vector<int> found = world.board.modes();
  world.robot.activate();
  HeadPort& head = *world.robot.head();
  EXPECT_FALSE(head.command(all_joints(5 * deg)).rejected);
  HeadState state;
  EXPECT_TRUE(eventually(1.0, [&] {
    head.read(state);
    return (state.head_position_rad() - all_joints(5 * deg)).norm() < 1e-6;
  }));
  ASSERT_TRUE(yarp::os::Network::disconnect(world.name + "/head/state:o",
                                            "/saccade" + world.name + "/head/state:i", true));
  EXPECT_TRUE(eventually(1.0, [&] { return head.read(state) == PortStatus::lost; }));
  EXPECT_EQ(head.stop(), PortStatus::lost);
  world.robot.release();
  EXPECT_TRUE(eventually(1.0, [&] { return world.board.modes() == found; }));
}

TEST_F(Yarp, TheGuardsConnectionTakesPositionDirectJointsAwayFromDeployAndLeavesTheOthers) {
  JointsWorld world;
  YarpHeadStopper guard(config_for(world.name), our_limits());
  EXPECT_TRUE(guard.is_connected());
  world.robot.activate();
  HeadPort& head = *world.robot.head();
  EXPECT_FALSE(head.command(all_joints(5 * deg)).rejected);
  EXPECT_TRUE(eventually(1.0, [&] { return std::abs(world.board.positions_deg().at(4) - 5.0) < 1e-6; }));
  world.board.set_mode(1, VOCAB_CM_IDLE);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_TRUE(guard.stop());
  std::cout << "the guard stopped the head in " << ms_since(began) << " ms\n";
  EXPECT_EQ(world.board.modes().at(0), VOCAB_CM_POSITION);
  EXPECT_EQ(world.board.modes().at(1), VOCAB_CM_IDLE);
}

TEST_F(Yarp, TheGuardsConnectionIsMadeAgainAfterItsBoardWasStartedAgain) {
  const std::string name = unique_name("/icub");
  const CountingGrabber grabber(name + "/AE:o");
  std::optional<Child> board;
  const auto start_board = [&] {
    board.emplace(std::vector<std::string>{SACCADE_YARP_PEER, "board", name + "/head"},
                  YarpWorld::get() / "board.log");
    return eventually(10.0, [&] {
      return yarp::os::Network::exists(name + "/head/state:o", true) &&
             yarp::os::Network::exists(name + "/head/rpc:i", true);
    });
  };
  ASSERT_TRUE(start_board());
  GuardHead guard([&] { return std::make_unique<YarpHeadStopper>(config_for(name), our_limits()); });
  EXPECT_TRUE(eventually(5.0, [&] { return guard.is_connected(); }));
  board->kill();
  EXPECT_TRUE(eventually(5.0, [&] { return !guard.is_connected(); }));
  EXPECT_FALSE(guard.stop());
  ASSERT_TRUE(start_board());
  EXPECT_TRUE(eventually(20.0, [&] { return guard.is_connected(); })) << guard.problem();
  EXPECT_TRUE(guard.stop());
}

TEST_F(Yarp, AFloodOfTextDoesNotTakeTheGuardFromItsHead) {
  JointsWorld world;
  GuardHead guard([&] { return std::make_unique<YarpHeadStopper>(config_for(world.name), our_limits()); });
  EXPECT_TRUE(eventually(5.0, [&] { return guard.is_connected(); }));
  const std::string input = "/saccade" + world.name + "/guard/head/state:i";
  const yarp::os::Contact to = yarp::os::Network::queryName(input);
  // With the names of a stranger and of the board itself, which YARP then takes for a new connection of the board.
  for (const std::string& from : {unique_name("/stranger"), world.name + "/head/state:o"}) {
    for (int i = 0; i < 100; ++i) {
      const int file = ::socket(AF_INET, SOCK_STREAM, 0);
      sockaddr_in address{};
      address.sin_family = AF_INET;
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      address.sin_port = htons(static_cast<std::uint16_t>(to.getPort()));
      ASSERT_EQ(::connect(file, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
      const std::string text = "CONNECT " + from + "\nd\n99 99 99 99 99 99\n";
      (void)!::write(file, text.data(), text.size());
      ::close(file);
    }
  }
  EXPECT_TRUE(eventually(20.0, [&] { return guard.is_connected(); })) << guard.problem();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_TRUE(eventually(20.0, [&] { return guard.is_connected() && guard.stop(); })) << guard.problem();
}

TEST_F(Yarp, TheServedCameraCountsItsReadersAndSendsThePolarityBitAsAsked) {
  for (const bool one_is_brighter : {false, true}) {
    YarpEventPort::Config config;
    config.name = unique_name("/camera") + "/AE:o";
    config.swap_polarity = one_is_brighter;
    YarpEventPort port(config);
    EXPECT_EQ(port.readers(), 0);
    struct Words final : yarp::os::PortReader {
      bool read(yarp::os::ConnectionReader& reader) override {
        std::vector<std::byte> bytes(reader.getSize());
        if (!reader.expectBlock(reinterpret_cast<char*>(bytes.data()), bytes.size())) return false;
        EventPacket packet;
        EXPECT_EQ(read_packet(bytes, PacketFormat::packet, packet), "");
        const std::lock_guard lock(mutex);
        for (const WireEvent& event : packet.events) words.push_back(event.address);
        return true;
      }
      std::mutex mutex;
      std::vector<std::uint32_t> words;
    } reader;
    yarp::os::Port input;
    input.setReader(reader);
    ASSERT_TRUE(input.open(unique_name("/reader")));
    ASSERT_TRUE(yarp::os::Network::connect(config.name, input.getName()));
    EXPECT_TRUE(eventually(1.0, [&] { return port.readers() == 1; }));
    // An edge that makes pixel 5 brighter and pixel 6 darker.
    const std::array<Event, 2> events = {Event{1000, 5, 60, true, 0}, Event{1000, 6, 60, false, 0}};
    port.send(events, 1000);
    EXPECT_TRUE(eventually(1.0, [&] {
      const std::lock_guard lock(reader.mutex);
      return reader.words.size() == 2;
    }));
    {
      const std::lock_guard lock(reader.mutex);
      EXPECT_EQ(reader.words.at(0) & 1, one_is_brighter ? 1u : 0u);
      EXPECT_EQ(reader.words.at(1) & 1, one_is_brighter ? 0u : 1u);
    }
    input.interrupt();
    input.close();
    EXPECT_TRUE(eventually(1.0, [&] { return port.readers() == 0; }));
  }
}

TEST_F(Yarp, TheReadingsOfAServedBoardStayNewDuringALongStepAndGetOldWhileTheSimulationHangs) {
  const std::string part = unique_name("/served") + "/head";
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(1);
  YarpControlBoard board({part, {"neck"}, 0.01}, JointBoard({{-1.0, 1.0, 1.0}}, rest, true));
  const SteadyClock clock;
  const StateInput input(unique_name("/reader"), part + "/state:o", "fast_tcp", 2.0, clock);
  const auto age_ms = [&] { return 1e-3 * static_cast<double>(clock.now_us() - input.state().t_us); };
  for (int i = 0; i < 100; ++i) {
    board.step(rest, rest, 0.001);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(eventually(2.0, [&] { return input.state().count == 1; }));
  board.step(rest, rest, 0.001);
  std::this_thread::sleep_for(std::chrono::milliseconds(120));  // a long step
  EXPECT_LT(age_ms(), 100.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  EXPECT_GT(age_ms(), 400.0) << "a simulation that hangs";
}

TEST_F(Yarp, MessagesOfAStrangerAndFalseCountsDoNotReachTheJoints) {
  JointsWorld world;
  HeadState before;
  ASSERT_TRUE(eventually(1.0, [&] { return world.robot.head()->read(before) == PortStatus::ok; }));
  yarp::os::BufferedPort<yarp::os::Bottle> stranger;
  ASSERT_TRUE(stranger.open(unique_name("/stranger")));
  ASSERT_TRUE(yarp::os::Network::connect(stranger.getName(), "/saccade" + world.name + "/head/state:i"));
  for (int i = 0; i < 200; ++i) {
    yarp::os::Bottle& message = stranger.prepare();
    message.clear();
    for (int j = 0; j < 6; ++j) message.addFloat64(99.0);
    stranger.write();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    HeadState state;
    ASSERT_EQ(world.robot.head()->read(state), PortStatus::ok);
    ASSERT_LT(state.position_rad.cwiseAbs().maxCoeff(), 60 * deg) << "a false reading";
  }
}

TEST_F(Yarp, NoStrangerFindsThePortsOfTheHeadThatYarpReads) {
  JointsWorld world;
  HeadState before;
  ASSERT_TRUE(eventually(1.0, [&] { return world.robot.head()->read(before) == PortStatus::ok; }));
  const std::string stream = "/saccade" + world.name + "/head/stateExt:i";
  EXPECT_FALSE(yarp::os::Network::queryName(stream).isValid()) << stream;
  HeadState after;
  EXPECT_TRUE(eventually(
      1.0, [&] { return world.robot.head()->read(after) == PortStatus::ok && after.t_us > before.t_us; }));
}

/// Bytes as a message.
struct Bytes final : yarp::os::PortWriter {
  std::vector<char> bytes;
  bool write(yarp::os::ConnectionWriter& writer) const override {
    writer.appendBlock(bytes.data(), bytes.size());
    return true;
  }
};

TEST_F(Yarp, AMessageWithAFalseLengthDoesNotReachAPortBehindACheckedPort) {
  struct Echo final : yarp::os::PortReader {
    bool read(yarp::os::ConnectionReader& reader) override {
      yarp::os::Bottle message;  // ends the program if a string in it has a false length
      if (!message.read(reader)) return false;
      if (yarp::os::ConnectionWriter* writer = reader.getWriter()) message.write(*writer);
      return true;
    }
  } echo;
  const std::string name = unique_name("/board");
  yarp::os::Port port;
  port.setReader(echo);
  port.setRpcMode(true);
  ASSERT_TRUE(port.open(name + "/rpc:i"));
  const CheckedPort checked(name + "/rpc:i", CheckedPort::Kind::requests);

  yarp::os::Bottle request("[set] [pos] 1 2.5 \"text\"");
  Bytes message;
  std::size_t size = 0;
  const char* binary = request.toBinary(&size);
  message.bytes.assign(binary, binary + size);
  const char text[] = "text";
  const auto at = std::search(message.bytes.begin(), message.bytes.end(), text, text + 4);
  ASSERT_NE(at, message.bytes.end());
  std::fill(at - 4, at, static_cast<char>(0xff));  // its length: -1
  yarp::os::Port stranger;
  ASSERT_TRUE(stranger.open(unique_name("/stranger")));
  ASSERT_TRUE(yarp::os::Network::connect(stranger.getName(), name + "/rpc:i"));
  stranger.write(message);

  yarp::os::RpcClient client;
  ASSERT_TRUE(client.open(unique_name("/client")));
  ASSERT_TRUE(yarp::os::Network::connect(client.getName(), name + "/rpc:i"));
  yarp::os::Bottle reply;
  ASSERT_TRUE(client.write(request, reply));
  EXPECT_EQ(reply.toString(), request.toString());
}

TEST_F(Yarp, OnlyAListAndNumbersReachAPortThatTakesCommands) {
  const std::string name = unique_name("/board");
  yarp::os::BufferedPort<yarp::os::Bottle> port;
  port.setStrict();
  ASSERT_TRUE(port.open(name + "/command:i"));
  const CheckedPort checked(name + "/command:i", CheckedPort::Kind::commands);
  const auto send = [&](const char* text) {
    yarp::os::Port client;
    ASSERT_TRUE(client.open(unique_name("/client")));
    ASSERT_TRUE(yarp::os::Network::connect(client.getName(), name + "/command:i"));
    yarp::os::Bottle message(text);
    client.write(message);
  };
  for (const char* bad : {"text", "1.0 2.0", "([pos] 1) (text)", "([pos] 1) ()", "(1.0 2.0) (1.0 2.0)",
                          "([pos] 1) (1.0) (2.0)", "([pos] 1) (1 2)"})
    send(bad);
  send("([pos] 1) (1.0 2.0)");
  const yarp::os::Bottle* came = nullptr;
  ASSERT_TRUE(eventually(2.0, [&] { return (came = port.read(false)) != nullptr; }));
  EXPECT_EQ(came->toString(), "([pos] 1) (1.0 2.0)");
  EXPECT_EQ(port.getPendingReads(), 0);
}

TEST_F(Yarp, PacketsOfAStrangerDoNotHideASilentCamera) {
  JointsWorld world;
  ASSERT_TRUE(eventually(1.0, [&] { return world.robot.events().traffic().packets > 10; }));
  Grabber stranger(unique_name("/stranger"), PacketFormat::packet);
  ASSERT_TRUE(yarp::os::Network::connect(stranger.port().getName(), "/saccade" + world.name + "/AE:i"));
  EventPacket packet{1000, {}};
  packet.events.push_back({0, encode_address({0, 77, 99, true, 0}, AddressCodec::ev2)});
  for (int i = 0; i < 50; ++i) {
    stranger.send(packet);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_THAT(world.robot.news(), Contains(HasSubstr("its messages are discarded")));
}

TEST_F(Yarp, TheTorsoIsReadInTheOrderOfTheChain) {
  const std::string name = unique_name("/icub");
  const CountingGrabber grabber(name + "/AE:o");
  const Board board(name + "/head");
  yarp::os::Port torso;
  torso.open(name + "/torso/state:o");
  YarpConfig config = config_for(name);
  config.head.torso_part = name + "/torso";
  YarpRobot robot(config, our_limits());
  yarp::os::Bottle yaw_roll_pitch("10.0 20.0 30.0");
  torso.write(yaw_roll_pitch);
  HeadState state;
  EXPECT_TRUE(eventually(1.0, [&] {
    robot.head()->read(state);
    return state.position_rad[torso_pitch] != 0.0;
  }));
  EXPECT_NEAR(state.position_rad[torso_pitch], 30 * deg, 1e-9);
  EXPECT_NEAR(state.position_rad[torso_roll], 20 * deg, 1e-9);
  EXPECT_NEAR(state.position_rad[torso_yaw], 10 * deg, 1e-9);
}

// ---- The gaze controller

TEST_F(Yarp, TargetsAreSentAtMostOncePerInterval) {
  GazeWorld world;
  world.robot.gaze()->look_at({-0.4, 0.0, 0.3});
  world.robot.activate();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 300; ++i) {
    world.robot.clock().wait_until(world.robot.clock().now_us() + 1000);
    if (i < 250) world.robot.gaze()->look_at({-0.5, 0.001 * i, 0.35});
  }
  ASSERT_TRUE(eventually(1.0, [&] { return !world.controller.targets().empty(); }));
  const double passed_ms = ms_since(begin);
  const auto targets = world.controller.targets();
  EXPECT_GE(targets.size(), 4u);
  EXPECT_LE(static_cast<double>(targets.size()), passed_ms / 75.0 + 2.0);
  EXPECT_EQ(targets.front().y, 0.0) << "nothing was sent before activate()";
  EXPECT_NEAR(targets.back().y, 0.249, 1e-12) << "the newest target is sent although it had to wait";
  EXPECT_EQ(targets.back().x, -0.5);
  EXPECT_EQ(targets.back().z, 0.35);
}

TEST_F(Yarp, SettingsAreSentOnActivationAndRestoredOnRelease) {
  GazeWorld world;
  world.robot.activate();
  EXPECT_THAT(world.controller.requests(),
              ElementsAre("stor", StartsWith("set Tneck 0.8"), StartsWith("set Teyes 0.4"), "set track 0",
                          "set sacc 0", "bind roll 0.0 0.0", "run"));
  EXPECT_EQ(world.robot.gaze()->stop(), PortStatus::ok);
  EXPECT_TRUE(eventually(1.0, [&] { return world.controller.requests().back() == "stop"; }));
  world.robot.release();
  const std::vector<std::string> requests = world.controller.requests();
  EXPECT_THAT(std::vector<std::string>(requests.end() - 3, requests.end()),
              ElementsAre("stop", "rest 7", "del 7"));
}

TEST_F(Yarp, ARejectedSettingRestoresTheSettingsOfTheGazeController) {
  GazeWorld world;
  world.controller.refuse("set Teyes");
  EXPECT_THROW(world.robot.activate(), RunError);
  EXPECT_THAT(world.controller.requests(), Contains("rest 7"));
}

TEST_F(Yarp, TheJointsOfTheGazeControllerAreTheHeadState) {
  GazeWorld world;
  EXPECT_THAT(failed(world.robot.check()), IsEmpty()) << text(world.robot.check());
  HeadState state;
  ASSERT_TRUE(eventually(1.0, [&] {
    world.robot.head()->read(state);
    return state.velocity_rad_s[0] != 0.0;
  }));
  for (int i = 0; i < joint_count; ++i) {
    EXPECT_NEAR(state.velocity_rad_s[i], 1.0 * deg, 1e-6);
    EXPECT_NEAR(state.position_rad[i] - state.position_rad[0], i * deg, 1e-9);
  }
  EXPECT_TRUE(world.robot.head()->command(HeadCommand::Zero()).rejected);
}

// ---- What goes wrong

TEST_F(Yarp, AKilledCameraIsLostAndCanRestartUnderTheSameName) {
  const std::string name = unique_name("/icub");
  EXPECT_TRUE(within_a_tenth_of_a_second([&] {
    Child grabber({SACCADE_YARP_PEER, "camera", name + "/AE:o"}, YarpWorld::get() / "grabber.log");
    EXPECT_TRUE(eventually(5.0, [&] { return yarp::os::Network::exists(name + "/AE:o"); }));
    YarpRobot robot(config_for(name, "none"), our_limits());
    EXPECT_THAT(failed(robot.check()), IsEmpty()) << text(robot.check());
    std::vector<Event> events;
    const auto killed = std::chrono::steady_clock::now();
    grabber.kill();
    EXPECT_TRUE(eventually(1.0, [&] { return robot.events().read_until(0, events) == PortStatus::lost; }));
    const double ms = ms_since(killed);
    EXPECT_EQ(robot.events().read_until(robot.clock().now_us(), events), PortStatus::lost) << "for good";
    return ms;
  }));
  const CountingGrabber grabber(name + "/AE:o");
  YarpRobot robot(config_for(name, "none"), our_limits());
  EXPECT_THAT(failed(robot.check()), IsEmpty()) << text(robot.check());
}

TEST_F(Yarp, AKilledControlBoardIsLost) {
  const std::string name = unique_name("/icub");
  const CountingGrabber grabber(name + "/AE:o");
  EXPECT_TRUE(within_a_tenth_of_a_second([&] {
    Child board({SACCADE_YARP_PEER, "board", name + "/head"}, YarpWorld::get() / "board.log");
    EXPECT_TRUE(eventually(10.0, [&] { return yarp::os::Network::exists(name + "/head/stateExt:o"); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // its device is attached after its ports
    YarpRobot robot(config_for(name), our_limits());
    robot.activate();
    HeadState state;
    EXPECT_EQ(robot.head()->read(state), PortStatus::ok);
    const auto killed = std::chrono::steady_clock::now();
    board.kill();
    EXPECT_TRUE(eventually(1.0, [&] { return robot.head()->read(state) == PortStatus::lost; }));
    const double ms = ms_since(killed);
    EXPECT_EQ(robot.head()->command(HeadCommand::Zero()).status, PortStatus::lost);
    robot.release();
    return ms;
  }));
}

class YarpCut : public testing::TestWithParam<const char*> {};

TEST_P(YarpCut, ConnectionIsLost) {
  YarpWorld::get();
  const std::string cut = GetParam();
  EXPECT_TRUE(within_a_tenth_of_a_second([&] {
    JointsWorld world;
    world.robot.activate();
    HeadState state;
    std::vector<Event> events;
    const auto lost = [&] {
      return world.robot.head()->read(state) == PortStatus::lost ||
             world.robot.events().read_until(world.robot.clock().now_us(), events) == PortStatus::lost;
    };
    EXPECT_FALSE(lost());
    const std::string local = "/saccade" + world.name;
    const auto begin = std::chrono::steady_clock::now();
    bool done = false;
    if (cut == "commands") {
      done = yarp::os::Network::disconnect(local + "/head/command:o", world.name + "/head/command:i", true);
    } else if (cut == "state") {
      done = yarp::os::Network::disconnect(world.name + "/head/state:o", local + "/head/state:i", true);
    } else {
      done = yarp::os::Network::disconnect(world.name + "/AE:o", local + "/AE:i", true);
    }
    EXPECT_TRUE(done);
    EXPECT_TRUE(eventually(1.0, lost));
    return ms_since(begin);
  }));
}

INSTANTIATE_TEST_SUITE_P(Yarp, YarpCut, testing::Values("commands", "state", "events"),
                         [](const auto& cut) { return std::string(cut.param); });

TEST_F(Yarp, AKilledGazeControllerIsLost) {
  const std::string name = unique_name("/icub");
  const CountingGrabber grabber(name + "/AE:o");
  auto controller = std::make_unique<GazeController>(name + "/gaze");
  YarpRobot robot(config_for(name, "gaze"), our_limits());
  robot.activate();
  EXPECT_EQ(robot.gaze()->look_at({-0.5, 0.0, 0.3}), PortStatus::ok);
  controller.reset();
  EXPECT_TRUE(eventually(1.0, [&] { return robot.gaze()->look_at({-0.5, 0.0, 0.3}) == PortStatus::lost; }));
  HeadState state;
  EXPECT_EQ(robot.head()->read(state), PortStatus::lost);
  EXPECT_EQ(robot.gaze()->stop(), PortStatus::lost);
  robot.release();
}

TEST_F(Yarp, ALostNameServerIsReportedAndOpenConnectionsContinue) {
  JointsWorld world;
  world.robot.activate();
  EXPECT_THAT(world.robot.news(), IsEmpty());
  YarpWorld::get().kill_name_server();
  std::vector<std::string> news;
  EXPECT_TRUE(eventually(5.0, [&] { return !(news = world.robot.news()).empty(); }));
  EXPECT_THAT(news, ElementsAre(HasSubstr("name server is lost")));
  std::vector<Event> events;
  world.robot.events().read_until(world.robot.clock().now_us(), events);
  events.clear();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(world.robot.events().read_until(world.robot.clock().now_us(), events), PortStatus::ok);
  EXPECT_GT(events.size(), 100u);
  const HeadCommand reference = all_joints(7 * deg);
  EXPECT_FALSE(world.robot.head()->command(reference).rejected);
  HeadState state;
  EXPECT_TRUE(eventually(1.0, [&] {
    return world.robot.head()->read(state) == PortStatus::ok &&
           (state.head_position_rad() - reference).norm() < 1e-6;
  }));
  YarpWorld::get().start_name_server();
  EXPECT_TRUE(eventually(5.0, [&] { return !(news = world.robot.news()).empty(); }));
  EXPECT_THAT(news, ElementsAre(HasSubstr("is back")));
}

TEST_F(Yarp, ReadersMayAskForText) {
  const JointsWorld world;
  YarpEventPort events({.name = world.name + "/events:o"});
  const std::vector<Event> shown = {{1000, 3, 4, true, 0}, {1000, 5, 6, false, 0}};
  for (const char* port : {"/head/state:o", "/head/stateExt:o", "/events:o"}) {
    yarp::os::BufferedPort<yarp::os::Bottle> reader;
    const std::string name = unique_name("/text");
    ASSERT_TRUE(reader.open(name));
    ASSERT_TRUE(connect_ports(world.name + port, name, "text", 5.0)) << port;
    for (int received = 0; received < 3; ++received) {
      events.send(shown, 1000);
      const yarp::os::Bottle* message = nullptr;
      ASSERT_TRUE(eventually(5.0, [&] { return (message = reader.read(false)) != nullptr; })) << port;
      EXPECT_GT(message->size(), 0u) << port;
    }
  }
}

TEST_F(Yarp, ASecondRobotOfTheSameNameIsRejected) {
  const JointsWorld world;
  EXPECT_THROW(YarpRobot(config_for(world.name), our_limits()), RunError);
}

TEST_F(Yarp, WithoutANameServerThereIsNoRobot) {
  YarpWorld::get().kill_name_server();
  EXPECT_THROW(YarpRobot(config_for("/icub"), our_limits()), RunError);
  YarpWorld::get().start_name_server();
}

}  // namespace
}  // namespace saccade
