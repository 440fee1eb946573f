// The live page of a deployed robot: what it shows, that it stops the head each time, and that a tick does not allocate.
#include "apps/deploy/live_deploy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "core/detectors/built_in_detectors.h"
#include "head/icub_cameras.h"
#include "tests/control/malloc_count.h"
#include "tests/deploy/fake_deployed.h"
#include "tests/live/live_client.h"

namespace saccade {
namespace {

namespace asio = boost::asio;

/// Stands for the recorder.
class NoRecord final : public DeployObserver {
 public:
  void on_tick(const Tick&, const TickTiming&) override {}
  void on_change(const DeployChange&) override {}
  void on_news(std::int64_t, const std::string&) override {}
};

/// What the page reads of a message: the JSON text behind its length.
nlohmann::json head_of(const std::string& message) {
  std::size_t length = 0;
  for (std::size_t i = 0; i < 4; ++i)
    length |= static_cast<std::size_t>(static_cast<unsigned char>(message.at(i))) << (8 * i);
  return nlohmann::json::parse(message.substr(4, length));
}

/// A session in fake time with a page, on 100 events per tick.
class LiveDeployTest : public testing::Test {
 protected:
  LiveDeployTest() {
    const FakeRobotScript script = script_with_busy_camera();
    robot_.emplace(script, false);
    std::vector<LoopDetector> detectors;
    detectors.push_back({"best", make_detector(built_in_detectors().config("best"), icub_left_2016)});
    loop_.emplace(
        *robot_, MountedCamera{icub_left_2016, {}}, std::move(detectors),
        LoopGaze{0, make_gate(built_in_gates().config()), std::nullopt, FollowConfig{.start_s = 0.0}});
    page_.emplace(record_, &server_,
                  LiveRun{.title = "fake", .kind = "deploy", .size = {128, 128}, .head = script.limits.head},
                  WatchdogConfig{}, *robot_, *loop_);
    session_.emplace(
        *robot_, *loop_,
        [limits = script.limits] {
          return LoopMotion{make_gaze_controller(built_in_controllers().config(), limits),
                            JointLimiter(motion_limits(limits, {}))};
        },
        requests_, *page_, DeploySessionConfig{.watchdog = {}, .joints_follow = false});
    session_->set_ready();
  }

  void activate() {
    requests_.activate();
    for (int i = 0; i < 5 && session_->state() != DeployState::active; ++i) ASSERT_TRUE(session_->tick());
    ASSERT_EQ(session_->state(), DeployState::active);
  }
  /// Ticks, each after a millisecond at least, until the state is reached; for a minute at most.
  bool reaches(DeployState state) {
    for (int i = 0; i < 60'000 && session_->state() != state; ++i) {
      if (!session_->tick()) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return session_->state() == state;
  }

  asio::io_context io_;
  NoRecord record_;
  OperatorRequests requests_;
  LiveServer server_{{.address = {}, .page = "", .stop = [this] { requests_.stop(); }}};
  std::optional<FakeDeployed> robot_;
  std::optional<Loop> loop_;
  std::optional<LiveDeploy> page_;
  std::optional<DeploySession> session_;
};

TEST_F(LiveDeployTest, TheButtonStopsTheHeadEachOfFiftyTimes) {
  for (int i = 0; i < 50; ++i) {
    activate();
    const auto page = opened_stream(server_.link(), io_);
    page->text(true);
    page->write(asio::buffer(std::string("stop")));
    ASSERT_TRUE(reaches(DeployState::stopped)) << "time " << i;
    EXPECT_EQ(session_->last_stop()->cause, StopCause::operator_stop);
    EXPECT_FALSE(robot_->is_active);
  }
  EXPECT_EQ(robot_->stops, 50);
}

TEST_F(LiveDeployTest, ThePageHasStateWatchdogsLogAndTheStop) {
  const auto page = opened_stream(server_.link(), io_);
  const auto greeting = head_of(next_message(*page));
  EXPECT_EQ(greeting.at("kind"), "deploy");
  EXPECT_EQ(greeting.at("can_stop"), true);
  EXPECT_EQ(greeting.at("watchdogs").size(), 3U);
  EXPECT_EQ(greeting.at("watchdogs")[0].at("bound"), WatchdogConfig{}.tick_late_ms);
  activate();
  // Ticks until a message with the state arrives.
  const auto shown = [&](const std::string& state) {
    nlohmann::json head;
    std::atomic<bool> found = false;
    std::thread reading([&] {
      do head = head_of(next_message(*page));
      while (!head.contains("state") || head.at("state") != state);
      found = true;
    });
    for (int i = 0; i < 60'000 && !found; ++i) {
      EXPECT_TRUE(session_->tick());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    reading.join();
    return head;
  };
  const auto active = shown("active");
  EXPECT_EQ(active.at("stops"), 0);
  EXPECT_EQ(active.at("alarm"), false);
  EXPECT_EQ(active.at("guarded"), true);
  page->text(true);
  page->write(asio::buffer(std::string("stop")));
  const auto stopped = shown("stopped");
  EXPECT_EQ(stopped.at("stops"), 1);
  EXPECT_THAT(stopped.at("lines").back().get<std::string>(), testing::HasSubstr("stopped"));
}

TEST_F(LiveDeployTest, ATickDoesNotAllocateWithAPageAndTwentyThatDoNotRead) {
  if (!malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc";
  std::vector<std::unique_ptr<LiveStream>> silent;
  for (int i = 0; i < 20; ++i) silent.push_back(opened_stream(server_.link(), io_));
  const auto page = opened_stream(server_.link(), io_);
  std::atomic<int> messages = 0;
  std::thread reading([&] {
    boost::beast::error_code error;
    for (boost::beast::flat_buffer buffer; !error; buffer.clear()) {
      page->read(buffer, error);
      ++messages;
    }
  });
  activate();
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(session_->tick());  // activation may allocate
  int first = 0;
  long allocations = 0;
  for (int i = 0; i < 1'000; ++i) {
    if (i == 100) first = messages;
    const long before = thread_malloc_count();
    ASSERT_TRUE(session_->tick());
    allocations += thread_malloc_count() - before;
    if (i % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(allocations, 0);
  // The page gets what the ticks hand over.
  for (int i = 0; i < 6'000 && messages <= first; ++i) {
    ASSERT_TRUE(session_->tick());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GT(messages, first);
  boost::system::error_code ignored;
  page->next_layer().shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  reading.join();
}

}  // namespace
}  // namespace saccade
