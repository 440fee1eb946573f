#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include "apps/deploy/robot_backends.h"
#include "apps/deploy/robot_check.h"
#include "apps/deploy/spsc_ring.h"
#include "apps/deploy/time_figures.h"
#include "core/error.h"
#include "core/random.h"
#include "robot/backend_registry.h"
#include "robot/yarp/yarp_config.h"
#include "session/close_within.h"
#include "session/real_time.h"

namespace {
int policy_while_locking = -1;
}

/// In place of the C library's.
extern "C" int mlockall([[maybe_unused]] int flags) noexcept {
  policy_while_locking = sched_getscheduler(0);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return 0;  // as the sanitizers' own: their tables of the whole address space do not fit into any memory
#else
  return static_cast<int>(syscall(SYS_mlockall, flags));
#endif
}

namespace saccade {
namespace {

/// Of threads that start from now on.
std::size_t stack_bytes() {
  pthread_attr_t attributes;
  std::size_t bytes = 0;
  if (pthread_getattr_default_np(&attributes) == 0) {
    pthread_attr_getstacksize(&attributes, &bytes);
    pthread_attr_destroy(&attributes);
  }
  return bytes;
}

TEST(RealTime, ThreadsThatStartLaterGetSmallStacksButNoLargerOnes) {
  pthread_attr_t attributes;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  for (const auto& [before, after] : {std::pair{4 * small_stack_bytes, small_stack_bytes},
                                      {small_stack_bytes / 2, small_stack_bytes / 2}}) {
    ASSERT_EQ(pthread_attr_setstacksize(&attributes, before), 0);
    ASSERT_EQ(pthread_setattr_default_np(&attributes), 0);
    use_small_stacks();
    EXPECT_EQ(stack_bytes(), after);
  }
  pthread_attr_destroy(&attributes);
}

TEST(RealTime, LocksTheMemoryBeforeItTakesThePriority) {
  const RealTime real_time;
  if (!real_time.granted()) GTEST_SKIP() << real_time.summary();
  EXPECT_EQ(policy_while_locking, SCHED_OTHER);
}

TEST(TimeFigures, QuantilesAreAtMostASixteenthTooLongAndNeverTooShort) {
  const RandomStream random(1, "times");
  TimeFigures figures;
  std::vector<std::int64_t> times;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    times.push_back(static_cast<std::int64_t>(std::exp2(random.uniform(0.0, 22.0, 0, i))));
    figures.add(times.back());
  }
  std::sort(times.begin(), times.end());
  for (const double share : {0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto at = static_cast<std::size_t>(std::ceil(share * static_cast<double>(times.size()))) - 1;
    const std::int64_t found = figures.quantile_us(share);
    EXPECT_GE(found, times[at]) << share;
    EXPECT_LE(static_cast<double>(found), 1.0626 * static_cast<double>(times[at]) + 1) << share;
  }
  EXPECT_EQ(figures.max_us(), times.back());
  EXPECT_EQ(figures.count(), 20'000);
}

TEST(TimeFigures, ShortTimesAreExactAndVeryLongOnesAreCounted) {
  TimeFigures figures;
  EXPECT_EQ(figures.quantile_us(0.5), 0);
  for (std::int64_t us = 0; us <= 31; ++us) {
    figures.clear();
    figures.add(us);
    figures.add(1'000);
    EXPECT_EQ(figures.quantile_us(0.5), us);
  }
  figures.add(-5);
  EXPECT_EQ(figures.quantile_us(0.3), 0);
  figures.add(std::int64_t{1} << 60);
  EXPECT_GT(figures.max_us(), 3600'000'000LL);
}

TEST(RobotBackends, AnUnknownBackendIsBadInputThatNamesThoseOfThisBuild) {
  RobotBackendConfig config = built_in_backends().config();
  config.backend = "ros";
  EXPECT_THAT([&] { (void)open_robot(config, {}); },
              testing::ThrowsMessage<InputError>(
                  testing::AllOf(testing::HasSubstr("ros"), testing::HasSubstr("recording, yarp"))));
}

/// The check whose name begins so.
StartUpCheck named(const std::vector<StartUpCheck>& checks, const std::string& name) {
  const auto found =
      std::ranges::find_if(checks, [&](const StartUpCheck& c) { return c.what.starts_with(name); });
  return found == checks.end() ? StartUpCheck{"no check " + name, false, {}} : *found;
}

TEST(CloseWithin, EndsTheProgramWithItsErrorWhileAConnectionDoesNotClose) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto never = [] {
    for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
  };
  EXPECT_EXIT(close_within(std::chrono::milliseconds(20), never, "the head was stopped: by the guard"),
              testing::ExitedWithCode(1), "do not close.*\nsaccade: the head was stopped: by the guard");
  EXPECT_EXIT(close_within(std::chrono::milliseconds(20), never, {}), testing::ExitedWithCode(0),
              "do not close");
}

TEST(CloseWithin, ReturnsWhenTheConnectionsAreClosed) {
  bool closed = false;
  close_within(
      std::chrono::hours(1), [&] { closed = true; }, "an error");
  EXPECT_TRUE(closed);
}

TEST(RobotCheck, NamesWhatTheMachineLacksWithoutConnectingToTheRobot) {
  RobotFile file;
  file.robot = built_in_backends().config();
  file.robot.backend = "practice";
  file.deploy.guard = GuardUse::none;
  file.output.least_free_mb = 0;
  auto checks = machine_checks(file, "/no/such/folder/runs");
  EXPECT_TRUE(named(checks, "YARP").passed) << "practice does without";
  EXPECT_TRUE(named(checks, "disk of /").passed) << "the nearest folder that exists";
  EXPECT_EQ(named(checks, "guard").found, "not used");
  EXPECT_TRUE(named(checks, "shared memory").passed);
  EXPECT_FALSE(named(checks, "real-time priority").found.empty());
  EXPECT_FALSE(named(checks, "locked memory").found.empty());

  file.output.least_free_mb = INT64_MAX / 2'000'000;
  checks = machine_checks(file, ".");
  EXPECT_FALSE(named(checks, "disk").passed);
  EXPECT_THAT(named(checks, "disk").found, testing::HasSubstr("MB free; --record ends at"));
#ifndef SACCADE_YARP
  file.robot.backend = "yarp";
  EXPECT_FALSE(named(machine_checks(file, "."), "YARP").passed);
  EXPECT_THAT(named(machine_checks(file, "."), "YARP").found, testing::HasSubstr("CMAKE_PREFIX_PATH"));
#endif
}

TEST(RobotCheck, ARequiredGuardThatIsNotThereIsMissing) {
  RobotFile file;
  file.robot = built_in_backends().config();
  file.robot.backend = "practice";
  ASSERT_FALSE(file.robot.head_name().empty());
  file.deploy.guard = GuardUse::required;
  const StartUpCheck guard = named(machine_checks(file, "."), "guard");
  EXPECT_FALSE(guard.passed) << "or a guard of the head `head` runs on this machine";
  EXPECT_THAT(guard.found, testing::HasSubstr("start `saccade guard`"));
}

TEST(RobotBackends, OnlyYarpWithItsGazeControllerTakesTargets) {
  RobotBackendConfig config = built_in_backends().config();
  EXPECT_FALSE(config.has_gaze_controller());
  config.backend = "yarp";
  EXPECT_FALSE(config.has_gaze_controller());
  config.get<YarpConfig>().head.control = "gaze";
  EXPECT_TRUE(config.has_gaze_controller());
}

TEST(RobotBackends, ABackendOfOnesOwnGetsItsConfigAndTheContext) {
  BackendRegistry registry;
  registry.add(backend_row("mine", "a test", RecordingBackendConfig{"here", 2.0},
                           [](const RecordingBackendConfig& config, const RobotContext& context) {
                             EXPECT_EQ(config.speed, 2.0);
                             EXPECT_EQ(context.image_size, (ImageSize{7, 5}));
                             return std::unique_ptr<Robot>();
                           }));
  EXPECT_EQ(open_robot(registry.config(), {{}, {7, 5}, {}}), nullptr);
}

TEST(SpscRing, PassesEveryElementOnceAndInOrderBetweenTwoThreads) {
  SpscRing<int> ring(7);
  constexpr int count = 20'000;
  std::thread sender([&] {
    for (int i = 0; i < count;) {
      if (int* const slot = ring.claim()) {
        *slot = i++;
        ring.publish();
      } else {
        std::this_thread::yield();
      }
    }
  });
  int received = 0;
  while (received < count) {
    const int* const slot = ring.front();
    if (slot == nullptr) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(*slot, received);
    ++received;
    ring.pop();
  }
  sender.join();
  EXPECT_EQ(ring.front(), nullptr);
}

TEST(SpscRing, AFullRingTakesNoMore) {
  SpscRing<int> ring(3);
  EXPECT_EQ(ring.room(), 3u);
  for (int i = 0; i < 3; ++i) {
    ASSERT_NE(ring.claim(), nullptr);
    ring.publish();
  }
  EXPECT_EQ(ring.room(), 0u);
  EXPECT_EQ(ring.claim(), nullptr);
  ring.pop();
  EXPECT_EQ(ring.room(), 1u);
  EXPECT_NE(ring.claim(), nullptr);
  const SpscRing<int> none(0);
  EXPECT_EQ(none.room(), 0u);
}

}  // namespace
}  // namespace saccade
