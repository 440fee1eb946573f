// When the loop has detectors work ahead.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "head/icub_cameras.h"
#include "loop/loop.h"
#include "robot/fake/fake_robot.h"

namespace saccade {
namespace {

/// Notes its calls, each by a letter. They do not overlap.
class NotingDetector final : public Detector {
 public:
  explicit NotingDetector(std::string& calls) : calls_(calls) {}
  void process(std::span<const Event>, const CameraMotion*) override { calls_ += 'p'; }
  void advance_to(std::int64_t, const CameraMotion*) override { calls_ += 'a'; }
  [[nodiscard]] Estimate estimate() override {
    calls_ += 'e';
    return {};
  }
  void work_ahead() override {
    calls_ += 'w';
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  std::string& calls_;
};

class Elapsed final : public LoopObserver {
 public:
  std::int64_t ns = 0;
  void on_tick(const Tick& tick) override { ns += tick.detectors.front().elapsed_ns; }
};

struct ThreeTicks {
  std::string calls;
  std::int64_t elapsed_ns = 0;

  explicit ThreeTicks(std::shared_ptr<WorkerThreads> threads, const LatencyConfig& latency = {}) {
    FakeRobot robot{FakeRobotScript{}};
    std::vector<LoopDetector> detectors;
    detectors.push_back({"noting", std::make_unique<NotingDetector>(calls)});
    Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::nullopt, Eye::left,
              std::nullopt, latency, std::move(threads));
    Elapsed elapsed;
    for (std::int64_t t_us = 1'000; t_us <= 3'000; t_us += 1'000)
      EXPECT_EQ(loop.tick(t_us, elapsed), PortStatus::ok);
    elapsed_ns = elapsed.ns;
  }
};

TEST(WorkAhead, ComesAfterTheCommandWithoutThreads) {
  EXPECT_EQ(ThreeTicks(nullptr).calls, "paewpaewpaew");
  EXPECT_EQ(ThreeTicks(std::make_shared<WorkerThreads>(1)).calls, "paewpaewpaew");
}

TEST(WorkAhead, ComesBeforeTheTicksEventsWithThreads) {
  EXPECT_EQ(ThreeTicks(std::make_shared<WorkerThreads>(2)).calls, "wpaewpaewpae");
}

TEST(WorkAhead, CountsAsTimeOfTheDetector) {
  EXPECT_GE(ThreeTicks(nullptr).elapsed_ns, 2'000'000);
  EXPECT_GE(ThreeTicks(std::make_shared<WorkerThreads>(2)).elapsed_ns, 3'000'000);
}

TEST(WorkAhead, BelongsToTheNextCallWhereTheLatencyIsMeasured) {
  LatencyConfig latency;
  latency.kind = LatencyKind::measured;
  EXPECT_EQ(ThreeTicks(nullptr, latency).calls.find('w'), std::string::npos);
}

}  // namespace
}  // namespace saccade
