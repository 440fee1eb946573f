// When events reach detectors, when estimates are ready, and when the head gets a command, with a latency.
#include "loop/latency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "control/open_gate.h"
#include "head/icub_cameras.h"
#include "loop/loop.h"
#include "loop/work_fit.h"
#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"
#include "tests/control/malloc_count.h"
#include "tests/loop/packet_robot.h"

namespace saccade {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::Le;

constexpr std::int64_t tick_us = 1000;

LatencyConfig model(double per_call_us, double per_event_us = 0.0) {
  LatencyConfig latency;
  latency.kind = LatencyKind::model;
  latency.detectors = {{"newest", {per_event_us, per_call_us}}};
  return latency;
}

/// One event in the middle of each millisecond up to end_ms, in the pixel of that millisecond; `count` of them at once.
FakeRobotScript events_each_millisecond(int end_ms, int count = 1) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  for (int t_ms = 1; t_ms <= end_ms; ++t_ms) {
    for (int i = 0; i < count; ++i)
      script.events.push_back({t_ms * tick_us - 500, static_cast<std::uint16_t>(t_ms % 128), 64, true, 0});
  }
  return script;
}

/// Results of the first detector in each tick.
struct Results final : LoopObserver {
  struct Result {
    bool busy = false;
    double x_px = 0.0;
    std::int64_t ready_us = 0;
    std::int64_t events = 0;
    std::int64_t left_out = 0;
    std::vector<std::int64_t> late_us;
    std::vector<std::int64_t> late_ready_us;
  };
  void on_tick(const Tick& tick) override {
    const DetectorTick& detector = tick.detectors.front();
    Result& result = by_tick[tick.t_us];
    result = {detector.busy,
              detector.estimate.circle.x_px,
              detector.ready_us,
              detector.events,
              detector.events_left_out,
              {},
              {}};
    for (const LateEstimate& late : detector.late) {
      result.late_us.push_back(late.t_us);
      result.late_ready_us.push_back(late.ready_us);
    }
    if (!detector.busy) ran_us.push_back(tick.t_us);
  }
  std::map<std::int64_t, Result> by_tick;
  std::vector<std::int64_t> ran_us;
};

Results results_of(Robot& robot, const LatencyConfig& latency, std::int64_t end_us) {
  std::vector<LoopDetector> detectors;
  detectors.push_back({"newest", std::make_unique<NewestEventDetector>()});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::nullopt, Eye::left,
            std::nullopt, latency);
  Results results;
  for (std::int64_t t_us = tick_us; t_us <= end_us; t_us += tick_us) loop.tick(t_us, results);
  return results;
}

TEST(TransportLatency, EventsReachTheDetectorInTheTickInWhichTheyArriveAndCountAtTheirOwnMilliseconds) {
  FakeRobot robot(events_each_millisecond(20));
  LatencyConfig latency = model(0.0);
  latency.transport_ms = 2.5;  // rounded up to 3
  Results results = results_of(robot, latency, 20'000);
  EXPECT_THAT(results.by_tick[3000].late_us, ElementsAre());
  EXPECT_THAT(results.by_tick[4000].late_us, ElementsAre(1000));
  EXPECT_EQ(results.by_tick[10'000].x_px, 7.0);
}

TEST(ProcessingLatency, AnEstimateIsReadyWhenTheWorkIsDone) {
  FakeRobot robot(events_each_millisecond(5, 10));
  Results results = results_of(robot, model(100.0, 20.0), 5000);
  EXPECT_EQ(results.by_tick[1000].ready_us, 1000 + 100 + 10 * 20);
  EXPECT_THAT(results.ran_us, ElementsAre(1000, 2000, 3000, 4000, 5000));
}

TEST(ProcessingLatency, SlicesOfLateEventsAreReadyOneAfterTheOther) {
  std::vector<Event> events;
  for (int t_ms = 1; t_ms <= 5; ++t_ms) events.push_back({t_ms * tick_us - 500, 1, 1, true, 0});
  PacketRobot robot(events);
  Results results = results_of(robot, model(100.0), 5000);
  EXPECT_THAT(results.by_tick[5000].late_us, ElementsAre(1000, 2000, 3000, 4000));
  EXPECT_THAT(results.by_tick[5000].late_ready_us, ElementsAre(5100, 5200, 5300, 5400));
  EXPECT_EQ(results.by_tick[5000].ready_us, 5500);
}

TEST(ProcessingLatency, EventsWaitForABusyDetectorAndAreProcessedInOneCall) {
  FakeRobot robot(events_each_millisecond(20));
  Results results = results_of(robot, model(2500.0), 10'000);
  EXPECT_THAT(results.ran_us, ElementsAre(1000, 4000, 7000, 10'000));
  EXPECT_TRUE(results.by_tick[2000].busy);
  EXPECT_EQ(results.by_tick[4000].events, 3);
  EXPECT_EQ(results.by_tick[4000].x_px, 4.0);
  EXPECT_EQ(results.by_tick[4000].ready_us, 6500);
}

TEST(ProcessingLatency, OfADetectorSlowerThanItsEventsIsBoundedBecauseTheOldestEventsAreDropped) {
  constexpr std::int64_t most_events = 100;
  FakeRobot robot(events_each_millisecond(500, 20));  // 4 ms of work in each
  LatencyConfig latency = model(0.0, 200.0);
  latency.max_waiting_events = most_events;
  const Results results = results_of(robot, latency, 500'000);
  std::int64_t done = 0;
  std::int64_t left_out = 0;
  std::vector<std::int64_t> took_us;
  for (const auto& [t_us, result] : results.by_tick) {
    done += result.events;
    left_out += result.left_out;
    if (!result.busy) took_us.push_back(result.ready_us - t_us);
  }
  EXPECT_THAT(took_us, Each(Le(most_events * 200)));
  EXPECT_EQ(took_us.back(), most_events * 200);
  EXPECT_NEAR(static_cast<double>(done), 500'000.0 / 200.0, 100.0) << "the detector never rests";
  EXPECT_NEAR(static_cast<double>(done + left_out), 500.0 * 20.0, 100.0) << "100 may still wait at the end";
  EXPECT_EQ(results.by_tick.at(results.ran_us.back()).x_px, results.ran_us.back() / tick_us % 128)
      << "the newest events stay";
}

/// Sees the ball at one place from the first tick on.
class StillBall final : public Detector {
 public:
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override { return {true, true, {90.0, 64.0, 10.0}, 1.0}; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }
};

/// Its reference for the neck pitch grows by 0.1 mrad with each step that has a target.
class CountingController final : public GazeController {
 public:
  HeadJointVector step(const HeadState&, const std::optional<Eigen::Vector3d>& target_m, double) override {
    if (target_m) reference_rad_[0] += 1e-4;
    status_ = target_m ? TargetStatus::ok : TargetStatus::none;
    return reference_rad_;
  }
  void rest() override {}
  [[nodiscard]] TargetStatus target_status() const override { return status_; }

 private:
  HeadJointVector reference_rad_ = HeadJointVector::Zero();
  TargetStatus status_ = TargetStatus::none;
};

/// The reference that the head has after each tick of the first 30 ms.
std::vector<double> references_of(LatencyConfig latency) {
  FakeRobotScript script = events_each_millisecond(0);
  FakeRobot robot(script);
  std::vector<LoopDetector> detectors;
  detectors.push_back({"newest", std::make_unique<StillBall>()});
  JointLimits limits = genova02_limits();
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
            LoopGaze{0, std::make_unique<OpenGate>(TargetConfig{}),
                     LoopMotion{std::make_unique<CountingController>(),
                                JointLimiter(motion_limits(limits, MotionLimitsConfig{}))},
                     FollowConfig{0.0}},
            Eye::left, std::nullopt, latency);
  Results results;
  std::vector<double> references_rad;
  for (std::int64_t t_us = tick_us; t_us <= 30'000; t_us += tick_us) {
    loop.tick(t_us, results);
    references_rad.push_back(robot.reference_rad()[0]);
  }
  return references_rad;
}

/// After how many ticks the first command that differs from the start reaches the head.
std::ptrdiff_t first_motion_ms(const LatencyConfig& latency) {
  const std::vector<double> references_rad = references_of(latency);
  const auto first = std::ranges::find_if(references_rad, [](double rad) { return rad > 0.0; });
  return first - references_rad.begin() + 1;
}

TEST(CommandLatency, TheHeadGetsACommandInTheFirstTickInWhichItIsReady) {
  EXPECT_EQ(first_motion_ms({}), 1);
  EXPECT_EQ(first_motion_ms(model(0.0)), 1) << "a latency of nothing";
  LatencyConfig actuation = model(0.0);
  actuation.actuation_ms = 7.0;
  EXPECT_EQ(first_motion_ms(actuation), 1 + 7);
  actuation.actuation_ms = 7.2;
  EXPECT_EQ(first_motion_ms(actuation), 1 + 8) << "not before it is ready";
}

TEST(CommandLatency, TimesOfDetectorControllerAndActuationAddUpBeforeTheyAreRoundedToATick) {
  LatencyConfig all = model(300.0);
  all.controller_us = 200.0;
  all.actuation_ms = 0.4;
  EXPECT_EQ(first_motion_ms(all), 1 + 1);
  all.actuation_ms = 0.6;
  EXPECT_EQ(first_motion_ms(all), 1 + 2);
  EXPECT_EQ(first_motion_ms(model(4200.0)), 1 + 5) << "the estimate of the first tick, ready at 5.2 ms";
}

TEST(CommandLatency, EveryCommandArrivesOnceAndInOrder) {
  LatencyConfig latency = model(0.0);
  latency.actuation_ms = 5.0;
  const std::vector<double> at_once = references_of(model(0.0));
  const std::vector<double> later = references_of(latency);
  for (std::size_t i = 5; i < later.size(); ++i) EXPECT_DOUBLE_EQ(later[i], at_once[i - 5]) << i;
}

/// Counts what a loop allocates from its tenth tick on.
struct Allocations final : LoopObserver {
  void on_tick(const Tick& tick) override {
    if (tick.t_us == 10'000) before = malloc_count();
    after = malloc_count();
  }
  long before = 0;
  long after = 0;
};

TEST(Latency, TicksWithALatencyDoNotAllocate) {
  if (!malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc";
  LatencyConfig latency = model(700.0, 50.0);
  latency.transport_ms = 20.0;
  latency.actuation_ms = 30.0;
  latency.max_waiting_events = 50;
  FakeRobot robot(events_each_millisecond(200, 20));
  const JointLimits limits = genova02_limits();
  std::vector<LoopDetector> detectors;
  detectors.push_back({"newest", std::make_unique<NewestEventDetector>()});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
            LoopGaze{0, std::make_unique<OpenGate>(TargetConfig{}),
                     LoopMotion{std::make_unique<CountingController>(),
                                JointLimiter(motion_limits(limits, MotionLimitsConfig{}))},
                     FollowConfig{0.0}},
            Eye::left, std::nullopt, latency);
  Allocations allocations;
  for (std::int64_t t_us = tick_us; t_us <= 200'000; t_us += tick_us) loop.tick(t_us, allocations);
  EXPECT_GT(allocations.before, 0);
  EXPECT_EQ(allocations.after, allocations.before);
}

TEST(FittedWork, IsThatOfTheSamplesWhateverAFewOfThemWaitedFor) {
  std::vector<WorkSample> samples;
  for (std::int64_t i = 0; i < 1000; ++i) {
    const std::int64_t calls = 1 + i % 3;
    const std::int64_t events = 37 * i % 400;
    const bool preempted = i % 250 == 7;
    samples.push_back({calls, events,
                       12.0 * static_cast<double>(calls) + 0.25 * static_cast<double>(events) +
                           (preempted ? 4000.0 : 0.0)});
  }
  const WorkTime work = fit_work(samples);
  EXPECT_NEAR(work.per_call_us, 12.0, 1e-6);
  EXPECT_NEAR(work.per_event_us, 0.25, 1e-6);
}

TEST(FittedWork, IsNeverNegativeAndZeroWithoutSamples) {
  const WorkTime falling = fit_work({{1, 100, 10.0}, {1, 200, 9.0}, {1, 300, 8.0}});
  EXPECT_EQ(falling.per_event_us, 0.0);
  EXPECT_NEAR(falling.per_call_us, 9.0, 1e-9);
  EXPECT_EQ(fit_work({}).per_call_us, 0.0);
}

}  // namespace
}  // namespace saccade
