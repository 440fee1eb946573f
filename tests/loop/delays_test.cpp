#include "loop/delays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loop/detector_runner.h"
#include "loop/seen_heads.h"
#include "loop/watchdog.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<Event> at(std::initializer_list<std::int64_t> times_us) {
  std::vector<Event> events;
  for (const std::int64_t t_us : times_us) events.push_back({t_us, 1, 1, true, 0});
  return events;
}

std::vector<std::int64_t> times(std::span<const Event> events) {
  std::vector<std::int64_t> result;
  for (const Event& event : events) result.push_back(event.t_us);
  return result;
}

TEST(TransportDelay, PassesEventsOnInTheTickInWhichTheyArrive) {
  TransportDelay transport(2'500, 16);
  EXPECT_THAT(times(transport.pass(at({100, 900}), 1'000)), IsEmpty());
  EXPECT_THAT(times(transport.pass(at({1'500}), 3'000)), ElementsAre(100));
  EXPECT_THAT(times(transport.pass({}, 4'000)), ElementsAre(900, 1'500)) << "the last one exactly now";
  EXPECT_THAT(times(transport.pass({}, 5'000)), IsEmpty()) << "each once";
}

TEST(CommandDelay, ReturnsTheNewestCommandThatHasReachedTheHead) {
  CommandDelay commands;
  const auto command = [](double rad) { return HeadCommand(HeadCommand::Constant(rad)); };
  commands.push(command(1.0), 2'000);
  commands.push(command(2.0), 1'500);  // not before the one before it
  commands.push(command(3.0), 4'000);
  EXPECT_FALSE(commands.pop(1'999));
  EXPECT_EQ(commands.pop(3'000)->x(), 2.0);
  EXPECT_FALSE(commands.pop(3'999));
  commands.clear();
  EXPECT_FALSE(commands.pop(9'000));
}

TEST(SeenHeads, ReturnTheStateOfTheTickAtOrBeforeATime) {
  SeenHeads heads;
  for (std::int64_t ms = 1; ms <= 1000; ++ms) {
    HeadState state;
    state.t_us = ms;
    heads.push(state, 1000 * ms);
  }
  EXPECT_EQ(heads.at(2'000'000).t_us, 1000);
  EXPECT_EQ(heads.at(990'000).t_us, 990);
  EXPECT_EQ(heads.at(990'999).t_us, 990);
  EXPECT_EQ(heads.at(0).t_us, 1000 - 511) << "the oldest known";
}

/// Notes how it is called; a call takes its number of events as its score.
class CalledDetector final : public Detector {
 public:
  void process(std::span<const Event> events, const CameraMotion*) override {
    calls.push_back(times(events));
    count_ = static_cast<double>(events.size());
  }
  void advance_to(std::int64_t now_us, const CameraMotion*) override { advanced_us = now_us; }
  void leave_out_work_before(std::int64_t t_us) override { work_from_us = t_us; }
  [[nodiscard]] Estimate estimate() override { return {true, false, {}, count_}; }
  [[nodiscard]] double threshold() const override { return 2.0; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

  std::vector<std::vector<std::int64_t>> calls;
  std::int64_t advanced_us = 0;
  std::optional<std::int64_t> work_from_us;

 private:
  double count_ = 0.0;
};

TEST(DetectorRunner, PassesLateEventsInSlicesThatEndWholeMillisecondsBeforeTheTick) {
  CalledDetector detector;
  DetectorRunner runner;
  const auto events = at({7'100, 7'900, 9'000, 9'500, 10'000});
  const DetectorTick tick = runner.run(detector, 10'000, 9'000, events, nullptr, [](const DetectorTick&) {});
  EXPECT_THAT(detector.calls,
              ElementsAre(ElementsAre(7'100, 7'900), ElementsAre(9'000), ElementsAre(9'500, 10'000)));
  ASSERT_EQ(tick.late.size(), 2U);
  EXPECT_EQ(tick.late[0].t_us, 8'000);
  EXPECT_EQ(tick.late[1].t_us, 9'000);
  EXPECT_EQ(detector.advanced_us, 10'000);
  EXPECT_TRUE(tick.observed && tick.on_time && tick.at_threshold);
  EXPECT_EQ(tick.calls, 3);
  EXPECT_EQ(tick.events, 5);
}

TEST(DetectorRunner, LimitsWorkInTheTimeThatTheDetectorIsAdvancedTo) {
  CalledDetector detector;
  DetectorRunner runner;
  const auto run = [&](std::int64_t t_us) {
    (void)runner.run(detector, t_us, t_us - 1000, {}, nullptr, [](const DetectorTick&) {});
  };
  run(10'000);
  EXPECT_EQ(detector.work_from_us, std::nullopt);
  runner.limit_work(2'000);
  run(11'000);
  EXPECT_EQ(detector.work_from_us, 9'000);
  runner.set_age(5'000);
  run(12'000);
  EXPECT_EQ(detector.advanced_us, 11'000) << "its time never goes back";
  EXPECT_EQ(detector.work_from_us, 9'000);
  run(20'000);
  EXPECT_EQ(detector.work_from_us, 13'000);
}

TEST(DetectorRunner, IsBusyForTheTimeOfItsWorkAndKeepsTheNewestEvents) {
  LatencyConfig latency;
  latency.kind = LatencyKind::model;
  latency.max_waiting_events = 2;
  latency.detectors = {{"slow", {0.0, 2'500.0}}};  // us per event, per call
  CalledDetector detector;
  DetectorRunner runner(latency, "slow");
  const auto run = [&](std::int64_t t_us, const std::vector<Event>& events) {
    return runner.run(detector, t_us, t_us - 1000, events, nullptr, [](const DetectorTick&) {});
  };
  EXPECT_EQ(run(1'000, at({1'000})).ready_us, 3'500);
  EXPECT_TRUE(run(2'000, at({1'700, 1'800})).busy);
  EXPECT_EQ(run(3'000, at({2'500})).events_left_out, 1) << "the oldest of three";
  const DetectorTick tick = run(4'000, {});
  EXPECT_FALSE(tick.busy);
  EXPECT_EQ(tick.events, 2);
}

TEST(FollowWatch, NamesTheJointThatIsFarFromItsReference) {
  FollowWatch watch(5.0);
  HeadJointVector reference = HeadJointVector::Zero();
  HeadJointVector position = HeadJointVector::Zero();
  TickFacts facts;
  for (std::int64_t t_us = 0; t_us <= 100'000; t_us += 1'000) {
    if (t_us >= 40'000) reference[1] = 10.0 * rad_per_deg;
    watch.update(t_us, reference, t_us, position);
  }
  watch.add_to(facts);
  ASSERT_TRUE(facts.lags_since_us);
  EXPECT_EQ(facts.lagging, torso_slots + 1);
  EXPECT_NEAR(static_cast<double>(*facts.lags_since_us), 40'000.0, 1'000.0);
  watch.clear();
  TickFacts after;
  watch.add_to(after);
  EXPECT_FALSE(after.lags_since_us);
}

TEST(Watchdog, ReportsASilentCamera) {
  const Watchdog watchdog({}, genova02_limits());
  TickFacts facts;
  facts.due_us = facts.now_us = 1'000'000;
  facts.heard_us = facts.now_us - 59'000;
  EXPECT_FALSE(watchdog.check(facts));
  facts.heard_us = facts.now_us - 61'000;
  const auto fault = watchdog.check(facts);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->cause, StopCause::camera_silent);
  EXPECT_EQ(fault->since_us, facts.heard_us);
}

}  // namespace
}  // namespace saccade
