// Events that come in packets of several milliseconds, and the instants that estimates are about.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "head/icub_cameras.h"
#include "loop/loop.h"
#include "tests/loop/packet_robot.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

/// In the middle of the millisecond that ends at t_ms, at the pixel (t_ms, 64).
Event event_in(int t_ms) { return {t_ms * 1000 - 500, static_cast<std::uint16_t>(t_ms), 64, true, 0}; }

/// What the detector reports in each tick of 1 ms.
struct Reports final : LoopObserver {
  void on_tick(const Tick& tick) override {
    const DetectorTick& result = tick.detectors.front();
    Report& report = by_tick[tick.t_us];
    report.observed = result.observed;
    report.on_time = result.on_time;
    report.x_px = result.estimate.circle.x_px;
    for (const LateEstimate& late : result.late)
      report.late.emplace_back(late.t_us, late.estimate.circle.x_px);
  }
  struct Report {
    bool observed = false;
    bool on_time = false;
    double x_px = 0.0;
    std::vector<std::pair<std::int64_t, double>> late;
  };
  std::map<std::int64_t, Report> by_tick;
};

Reports reports_of(std::vector<Event> events, std::optional<LoopBudget> budget = std::nullopt) {
  PacketRobot robot(std::move(events));
  std::vector<LoopDetector> detectors;
  detectors.push_back({"newest", std::make_unique<NewestEventDetector>()});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::nullopt, Eye::left, budget);
  Reports reports;
  for (std::int64_t t_us = 1000; t_us <= 10'000; t_us += 1000) loop.tick(t_us, reports);
  return reports;
}

TEST(LateEvents, ArePassedInSlicesOfAMillisecondAndTheEstimateIsAboutTheSlicesEnd) {
  Reports reports = reports_of({event_in(1), event_in(2), event_in(4), event_in(5), event_in(7)});
  EXPECT_THAT(reports.by_tick[5000].late, ElementsAre(Pair(1000, 1.0), Pair(2000, 2.0), Pair(4000, 4.0)));
  EXPECT_TRUE(reports.by_tick[5000].on_time);
  EXPECT_EQ(reports.by_tick[5000].x_px, 5.0);
  for (const std::int64_t t_us : {1000, 4000, 6000, 9000}) {
    EXPECT_FALSE(reports.by_tick[t_us].observed) << t_us;
    EXPECT_THAT(reports.by_tick[t_us].late, IsEmpty()) << t_us;
  }
}

TEST(LateEvents, DoNotMakeAnObservationAtTheTickThatDeliversThem) {
  Reports reports = reports_of({event_in(7)});
  EXPECT_THAT(reports.by_tick[10'000].late, ElementsAre(Pair(7000, 7.0)));
  EXPECT_TRUE(reports.by_tick[10'000].observed);
  EXPECT_FALSE(reports.by_tick[10'000].on_time);
}

TEST(LateEvents, ArePassedToShadowDetectorsAtOnceWhereTicksHaveABudget) {
  Reports reports = reports_of({event_in(1), event_in(2), event_in(5)}, LoopBudget{1000, 1'000'000});
  EXPECT_THAT(reports.by_tick[5000].late, IsEmpty());
  EXPECT_EQ(reports.by_tick[5000].x_px, 5.0);
}

}  // namespace
}  // namespace saccade
