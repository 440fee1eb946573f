// The guard, the watch for hanging ticks, and the head that processes share.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <condition_variable>
#include <csignal>
#include <functional>
#include <mutex>
#include <thread>

#include "apps/deploy/guard_head.h"
#include "apps/deploy/guard_link.h"
#include "apps/deploy/hang_watch.h"
#include "apps/deploy/practice_robot.h"
#include "apps/deploy/shared_head.h"
#include "core/error.h"
#include "robot/fake/fake_robot.h"
#include "robot/head_limits.h"

namespace saccade {
namespace {

using testing::HasSubstr;

constexpr std::int64_t bound_ns = 40'000'000;

/// A name that no other process has; its memory is removed at the end.
class HeadName {
 public:
  HeadName() : name_("test-" + std::to_string(::getpid())) {}
  ~HeadName() {
    for (const char* kind : {"guard-", "practice-", "guarding-"})
      ::unlink(("/dev/shm/saccade-" + std::string(kind) + name_).c_str());
  }
  operator const std::string&() const { return name_; }  // NOLINT

 private:
  std::string name_;
};

/// A guard that looks at the board of a head and reaches it.
struct Guarded {
  explicit Guarded(const HeadName& name)
      : memory("guard-" + static_cast<const std::string&>(name), sizeof(GuardBoard)),
        board(*static_cast<GuardBoard*>(memory.data())) {
    board.guard_hang_ns = bound_ns;
    board.guard_ns = machine_ns() + 1'000'000'000'000;  // from now on, whatever the time
    board.connected = 1;
  }
  SharedMemory memory;
  GuardBoard& board;
};

// ---- the guard's decision ------------------------------------------------------------------------

TEST(GuardWatch, StopsOnceForEachActivationWhoseTicksCease) {
  GuardBoard board{};
  GuardWatch watch(bound_ns);
  board.tick_ns = 1'000'000'000;
  EXPECT_EQ(watch.look(board, 9'000'000'000), GuardWatch::Action::none) << "the head does not move";
  board.moving = 1;
  board.tick_ns = 9'000'000'000;
  EXPECT_EQ(watch.look(board, 9'000'000'000 + bound_ns), GuardWatch::Action::none);
  EXPECT_EQ(watch.look(board, 9'000'000'001 + bound_ns), GuardWatch::Action::stop);
  EXPECT_EQ(watch.age_ns(), bound_ns + 1);
  EXPECT_EQ(watch.look(board, 9'900'000'000), GuardWatch::Action::none) << "once";
  board.moving = 2;
  board.tick_ns = 10'000'000'000;
  EXPECT_EQ(watch.look(board, 10'000'000'000), GuardWatch::Action::none);
  EXPECT_EQ(watch.look(board, 10'100'000'000), GuardWatch::Action::stop);
}

TEST(GuardLink, RequiredGuardThatIsAbsentRefusesActivationAndItsLossStopsTheHead) {
  const HeadName name;
  GuardLink link(name, GuardUse::required, bound_ns);
  SharedMemory memory("guard-" + static_cast<const std::string&>(name), sizeof(GuardBoard));
  GuardBoard& board = *static_cast<GuardBoard*>(memory.data());
  EXPECT_THAT(link.why_not(), HasSubstr("start `saccade guard`"));
  board.guard_hang_ns = bound_ns;
  board.guard_ns = machine_ns() + 1'000'000'000'000;  // it looks from now on
  EXPECT_THAT(link.why_not(), HasSubstr("has no connection to it")) << "and does not reach the head";
  board.connected = 1;
  EXPECT_EQ(link.why_not(), "");
  link.activating();
  link.activated();
  EXPECT_EQ(board.moving, board.activations);
  EXPECT_FALSE(link.fault());
  EXPECT_TRUE(link.protects());
  board.guard_ns = machine_ns() - 2 * bound_ns;
  ASSERT_TRUE(link.fault());
  EXPECT_FALSE(link.protects());
  board.guard_ns = machine_ns() + 1'000'000'000'000;
  EXPECT_FALSE(link.fault());
  board.connected = 0;
  ASSERT_TRUE(link.fault()) << "a guard that does not reach its head counts as none";
  EXPECT_EQ(link.fault()->cause, StopCause::guard_lost);
}

TEST(GuardLink, RequiredGuardThatIsLostDuringAnActivationStopsTheHead) {
  const HeadName name;
  GuardLink link(name, GuardUse::required, bound_ns);
  Guarded guarded(name);
  EXPECT_EQ(link.why_not(), "");
  link.activating();
  guarded.board.connected = 0;
  link.activated();
  ASSERT_TRUE(link.fault());
  EXPECT_EQ(link.fault()->cause, StopCause::guard_lost);
}

TEST(GuardLink, AGuardWithAnotherBoundCountsAsNone) {
  const HeadName name;
  GuardLink link(name, GuardUse::required, bound_ns);
  Guarded guarded(name);
  EXPECT_EQ(guarded.board.hang_ns, bound_ns) << "the guard reads it here";
  guarded.board.guard_hang_ns = 2 * bound_ns;
  EXPECT_FALSE(link.has_guard());
  EXPECT_THAT(link.why_not(), HasSubstr("hang_ms 80, and this deploy 40"));
}

TEST(GuardLink, SaysWhatAnUnguardedActivationLacksAndNoticesALaterGuard) {
  const HeadName name;
  GuardLink link(name, GuardUse::optional, bound_ns);
  EXPECT_EQ(link.why_not(), "");
  link.activating();
  link.activated();
  EXPECT_THAT(link.warning(), HasSubstr("no guard: none watches this head"));
  EXPECT_FALSE(link.fault());
  EXPECT_FALSE(link.protects());
  Guarded guarded(name);
  EXPECT_FALSE(link.fault());
  EXPECT_TRUE(link.protects());
  EXPECT_EQ(link.warning(), "");
  guarded.board.connected = 0;
  EXPECT_FALSE(link.fault());
  EXPECT_FALSE(link.protects());
  EXPECT_THAT(link.warning(), HasSubstr("no connection"));
}

TEST(GuardLink, AHeadWithGuardNoneIsSaidToHaveNone) {
  const HeadName name;
  GuardLink link(name, GuardUse::none, bound_ns);
  const Guarded guarded(name);
  link.activating();
  link.activated();
  EXPECT_FALSE(link.protects());
  EXPECT_EQ(link.warning(), "no guard: deploy.guard is none");
}

TEST(GuardLink, AfterAStopByTheGuardTheHeadNeedsANewActivation) {
  const HeadName name;
  GuardLink link(name, GuardUse::optional, bound_ns);
  SharedMemory memory("guard-" + static_cast<const std::string&>(name), sizeof(GuardBoard));
  GuardBoard& board = *static_cast<GuardBoard*>(memory.data());
  link.activating();
  link.activated();
  board.stopped = board.moving.load();
  ASSERT_TRUE(link.fault());
  EXPECT_EQ(link.fault()->cause, StopCause::guard_stops);
  link.stopped();
  EXPECT_NE(board.moving, 0u) << "the stop may not have been sent";
  link.released();
  EXPECT_EQ(board.moving, 0u);
  link.activating();
  link.activated();
  EXPECT_FALSE(link.fault());
}

TEST(GuardLink, ASecondDeployOnTheSameHeadIsRefused) {
  const HeadName name;
  const GuardLink first(name, GuardUse::none, bound_ns);
  EXPECT_THAT([&] { GuardLink second(name, GuardUse::none, bound_ns); },
              testing::ThrowsMessage<RunError>(HasSubstr("another deploy on this machine moves the head")));
}

// ---- the guard's connection -----------------------------------------------------------------------

/// A head that a test disconnects.
struct Reach {
  std::atomic<bool> there = true;
  std::atomic<int> opened = 0, closed = 0, stops = 0;
};

class TestStopper final : public HeadStopper {
 public:
  explicit TestStopper(Reach& reach) : reach_(reach) { ++reach_.opened; }
  ~TestStopper() override { ++reach_.closed; }
  bool is_connected() override {
    lost_ = lost_ || !reach_.there;  // as over YARP: a lost connection stays lost
    return !lost_;
  }
  bool stop() override {
    if (!is_connected()) return false;
    ++reach_.stops;
    return true;
  }

 private:
  Reach& reach_;
  bool lost_ = false;
};

TEST(GuardHead, MakesALostConnectionAgain) {
  using std::chrono::milliseconds;
  Reach reach;
  GuardHead head([&] { return std::make_unique<TestStopper>(reach); }, milliseconds(1), milliseconds(1));
  EXPECT_TRUE(head.is_connected());
  EXPECT_TRUE(head.stop());
  reach.there = false;
  EXPECT_FALSE(head.is_connected());
  EXPECT_FALSE(head.stop());
  while (head.problem().empty()) {
    EXPECT_FALSE(head.is_connected());
    std::this_thread::yield();
  }
  EXPECT_EQ(head.problem(), "the head does not answer");
  reach.there = true;  // its board was started again
  while (!head.is_connected()) std::this_thread::yield();
  EXPECT_TRUE(head.stop());
  EXPECT_EQ(reach.stops, 2);
  EXPECT_EQ(reach.opened, reach.closed + 1) << "the connection before is closed first";
}

TEST(GuardHead, AnAttemptThatThrowsIsRepeatedAndTheFirstOneThrows) {
  using std::chrono::milliseconds;
  Reach reach;
  std::atomic<bool> has_network = true;
  const auto open = [&]() -> std::unique_ptr<HeadStopper> {
    if (!has_network) throw RunError("no name server");
    return std::make_unique<TestStopper>(reach);
  };
  GuardHead head(open, milliseconds(1), milliseconds(1));
  reach.there = false;
  has_network = false;
  while (head.problem() != "no name server") (void)head.is_connected();
  EXPECT_THROW(GuardHead second(open), RunError);
  reach.there = true;
  has_network = true;
  while (!head.is_connected()) std::this_thread::yield();
}

// ---- memory of several users ------------------------------------------------------------------------

TEST(SharedMemory, OpensTheFileOfAnotherUserAndNamesOneWhoDoesNotPermitIt) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root to be two users";
  const HeadName name;
  const std::string memory = "guard-" + static_cast<const std::string&>(name);
  const std::string path = "/dev/shm/saccade-" + memory;
  // A user's program creates it and ends; another one's, and root's, use it.
  const auto as_user = [](uid_t user, const std::function<int()>& work) {
    const pid_t child = ::fork();
    if (child == 0) {
      ::umask(077);
      ::_exit(::setuid(user) == 0 ? work() : 9);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  const auto use = [&] {
    try {
      SharedMemory shared(memory, 64);
      return ++*static_cast<char*>(shared.data()) + 10;
    } catch (const RunError& error) {
      const std::string text = error.what();
      return text.find("belongs to the user nobody") != std::string::npos &&
                     text.find("rm " + path) != std::string::npos
                 ? 1
                 : 2;
    }
  };
  constexpr uid_t nobody = 65534;
  EXPECT_EQ(as_user(nobody, use), 11);
  EXPECT_EQ(as_user(1234, use), 12);
  EXPECT_EQ(use(), 13);
  ::chmod(path.c_str(), 0600);
  EXPECT_EQ(as_user(1234, use), 1);
}

TEST(SharedMemory, GrowsAFileThatExistsAndPermitsEveryUserToWriteIt) {
  const HeadName name;
  const std::string memory = "guard-" + static_cast<const std::string&>(name);
  const std::string path = "/dev/shm/saccade-" + memory;
  struct stat before {
  }, after{};
  const SharedMemory first(memory, 64);
  ASSERT_EQ(::stat(path.c_str(), &before), 0);
  const SharedMemory second(memory, 128);
  ASSERT_EQ(::stat(path.c_str(), &after), 0);
  EXPECT_EQ(before.st_ino, after.st_ino);
  EXPECT_EQ(after.st_size, 128);
  EXPECT_EQ(after.st_mode & 0777, 0666u);
}

// ---- the shared head -----------------------------------------------------------------------------

TEST(SharedHead, FollowsReferencesBetweenTakeAndHoldOnly) {
  const HeadName name;
  SharedHead mover(name);
  SharedHead stopper(name);
  const HeadJointVector reference_rad = HeadJointVector::Constant(0.2);
  EXPECT_FALSE(mover.command(0, reference_rad)) << "not taken";
  const std::uint64_t number = mover.take();
  EXPECT_TRUE(mover.command(number, reference_rad));
  const HeadState later = stopper.state(machine_ns() + 1'000'000'000);
  EXPECT_NEAR(later.position_rad[neck_yaw], 0.2, 1e-9) << "the other process sees it";
  stopper.hold();
  EXPECT_FALSE(mover.follows());
  EXPECT_FALSE(mover.command(number, HeadJointVector::Constant(-0.3)));
  const HeadState held = mover.state(machine_ns());
  EXPECT_EQ(mover.state(machine_ns() + 1'000'000'000).position_rad, held.position_rad) << "and it stands";
  EXPECT_TRUE(held.velocity_rad_s.isZero());
}

TEST(SharedHead, AProcessKilledAtAnyInstantLeavesAHeadThatCanBeStopped) {
  const HeadName name;
  SharedHead head(name);
  for (int trial = 0; trial < 50; ++trial) {
    const pid_t child = ::fork();
    if (child == 0) {
      SharedHead mover(name);
      const std::uint64_t number = mover.take();
      for (int i = 0;; ++i) (void)mover.command(number, HeadJointVector::Constant(i % 2 == 0 ? 0.3 : -0.3));
    }
    const std::int64_t before_ns = head.commanded_ns();
    while (head.commanded_ns() == before_ns) std::this_thread::yield();
    ::usleep(static_cast<useconds_t>(trial * 7));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_TRUE(head.state(machine_ns()).position_rad.allFinite());
    head.hold();
    EXPECT_FALSE(head.follows());
    EXPECT_LE(head.state(machine_ns()).position_rad.cwiseAbs().maxCoeff(), 0.3 + 1e-9);
  }
}

// ---- a tick that hangs ---------------------------------------------------------------------------

/// A robot whose head hangs in read() until it is halted.
class HangingRobot final : public Robot {
 public:
  Clock& clock() override { return world_; }
  EventSource& events() override { return world_; }
  HeadPort* head() override { return nullptr; }
  void halt() override {
    const std::lock_guard lock(mutex_);
    halted_ = true;
    changed_.notify_all();
  }
  void hang() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return halted_; });
  }

 private:
  FakeRobot world_{{}};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool halted_ = false;
};

TEST(HangWatch, HaltsTheRobotWhileTheTickHangsInAPort) {
  HangingRobot robot;
  HangWatch watch(robot, {.bound_ns = 5'000'000, .end_after_ns = 0});
  watch.activating();
  watch.activated();
  robot.hang();  // for ever, without the watch
  while (!watch.fault()) std::this_thread::yield();
  EXPECT_EQ(watch.fault()->cause, StopCause::tick_hangs);
  EXPECT_GE(watch.fault()->amount, 5.0);
  watch.stopped();
  watch.activating();
  EXPECT_FALSE(watch.fault()) << "until the next activation";
}

TEST(HangWatch, EndsTheProgramIfTheTickHangsOn) {
  HangingRobot robot;
  std::atomic<bool> ended = false;
  HangWatch watch(robot, {.bound_ns = 1'000'000, .end_after_ns = 10'000'000}, {}, [&] { ended = true; });
  watch.activating();
  watch.activated();
  while (!ended) std::this_thread::yield();
  SUCCEED();
}

TEST(PracticeRobot, IgnoresCommandsAfterAHaltUntilItIsActivatedAgain) {
  const HeadName name;
  PracticeConfig config;
  config.head = name;
  PracticeRobot robot(config, {joint_limits({}), {128, 128}, {}});
  EXPECT_TRUE(robot.command(HeadCommand::Zero()).rejected) << "not active";
  robot.activate();
  EXPECT_FALSE(robot.command(HeadCommand::Constant(0.1)).rejected);
  robot.halt();
  EXPECT_TRUE(robot.command(HeadCommand::Constant(0.1)).rejected);
  EXPECT_EQ(robot.drives().joints[0], JointDrive::held);
  robot.activate();
  EXPECT_FALSE(robot.command(HeadCommand::Constant(0.1)).rejected);
  robot.release();
}

}  // namespace
}  // namespace saccade
