// What the loop has detectors do beside its own thread, and when.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#include "control/open_gate.h"
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

/// Throws in a chosen call of the third tick; its calls take a while.
class ThrowingDetector final : public Detector {
 public:
  enum class In { nothing, process, estimate, work_ahead };
  ThrowingDetector(In in, std::atomic<int>& under_way, int& calls)
      : in_(in), under_way_(under_way), calls_(calls) {}
  void process(std::span<const Event>, const CameraMotion*) override {
    ++ticks_;
    work(In::process, 0);
  }
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override {
    work(In::estimate, 300);
    return {};
  }
  void work_ahead() override { work(In::work_ahead, 300); }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  void work(In in, int us) {
    ++under_way_;
    std::this_thread::sleep_for(std::chrono::microseconds(us));
    ++calls_;
    --under_way_;
    if (ticks_ == 3 && in == in_) throw std::runtime_error("the detector's own");
  }

  In in_;
  std::atomic<int>& under_way_;
  int& calls_;
  int ticks_ = 0;
};

TEST(DetectorsBesideTheLoop, AnExceptionOfAnyOfThemLeavesTheTickOnceAllCallsHaveEnded) {
  using In = ThrowingDetector::In;
  constexpr std::size_t count = 4;
  for (const std::size_t threads : {1U, 2U, 3U}) {
    for (const In in : {In::process, In::estimate, In::work_ahead}) {
      for (std::size_t thrower = 0; thrower < count; ++thrower) {  // 0 drives
        std::atomic<int> under_way = 0;
        std::array<int, count> calls{};
        FakeRobot robot{FakeRobotScript{}};
        std::vector<LoopDetector> detectors;
        for (std::size_t i = 0; i < count; ++i)
          detectors.push_back({"detector", std::make_unique<ThrowingDetector>(i == thrower ? in : In::nothing,
                                                                              under_way, calls[i])});
        Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
                  LoopGaze{0, std::make_unique<OpenGate>(TargetConfig{}), std::nullopt, {}}, Eye::left,
                  std::nullopt, {}, std::make_shared<WorkerThreads>(threads));
        Elapsed observer;
        std::string message;
        for (std::int64_t t_us = 1'000; message.empty() && t_us <= 10'000; t_us += 1'000) {
          try {
            loop.tick(t_us, observer);
          } catch (const std::runtime_error& error) {
            message = error.what();
          }
          EXPECT_EQ(under_way, 0) << "a call goes on after the tick";
        }
        EXPECT_EQ(message, "the detector's own") << threads << " threads, detector " << thrower;
        const std::array<int, count> at_end = calls;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        EXPECT_EQ(calls, at_end);
      }
    }
  }
}

}  // namespace
}  // namespace saccade
