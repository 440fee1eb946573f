// Scores by event time and of the newest estimate that is ready, where events come late.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "head/icub_cameras.h"
#include "session/newest_estimate.h"
#include "session/reorder_buffer.h"
#include "session/run_scores.h"
#include "session/run_tables.h"
#include "session/session.h"
#include "tests/loop/packet_robot.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::ElementsAre;

constexpr std::int64_t end_us = 50'000;

/// A ball that moves by 2 px per ms, and an event at its centre in each.
double x_px(std::int64_t t_us) { return 10.0 + 2e-3 * static_cast<double>(t_us); }

/// The truth of that world, before scores and tables read it.
class MovingBall final : public LoopObserver {
 public:
  explicit MovingBall(const PacketRobot& robot) : robot_(robot) {}
  void on_tick(const Tick& tick) override {
    truth.t_us = tick.t_us;
    truth.events_until_us = robot_.sent_us();
    truth.ball_m = {0.0, 0.0, 0.5};
    truth.left.visible = 1.0;
    truth.left.circle = Circle{x_px(tick.t_us), 64.0, 20.0};
  }
  SimTruth truth;

 private:
  const PacketRobot& robot_;
};

/// The metrics of a detector that reports the newest event, over 50 ms.
Metrics metrics_of(const std::filesystem::path& folder, const LatencyConfig& latency) {
  std::vector<Event> events;
  for (std::int64_t t_us = 1000; t_us <= end_us; t_us += 1000)
    events.push_back({t_us, static_cast<std::uint16_t>(x_px(t_us)), 64, true, 0});
  PacketRobot robot(events);
  std::vector<LoopDetector> detectors;
  detectors.push_back({"newest", std::make_unique<NewestEventDetector>()});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::nullopt, Eye::left,
            std::nullopt, latency);
  Scenario scenario;
  scenario.latency = latency;
  scenario.gaze.detector = "none";
  scenario.output.formats = built_in_formats();
  MovingBall world(robot);
  const GroundTruth truth(world.truth, [] { return std::span<const EventLabel>(); });
  Observations observations(loop, truth, nullptr, latency);
  RunTables tables(folder, scenario, truth, loop, observations);
  RunScores scores(scenario, truth, genova02_limits(), loop, observations, nullptr);
  Session session(robot, loop);
  for (LoopObserver* const observer :
       std::initializer_list<LoopObserver*>{&world, &observations, &tables, &scores})
    session.add_observer(*observer);
  session.run(1000, end_us);
  observations.finish();
  tables.commit();
  return scores.metrics();
}

DetectorScore score_of(const std::filesystem::path& folder, const LatencyConfig& latency = {}) {
  return metrics_of(folder, latency).detectors.at(0).second;
}

LatencyConfig latency_of(LatencyKind kind, double transport_ms, double per_call_us) {
  LatencyConfig latency;
  latency.kind = kind;
  latency.transport_ms = transport_ms;
  latency.detectors = {{"newest", {0.0, per_call_us}}};
  return latency;
}

TEST(EventTimeScore, IsThatOfTheInstantsOfTheEventsHoweverLateTheyCome) {
  TempFolder folder;
  const DetectorScore score = score_of(folder / "");
  EXPECT_EQ(score.chances, 50);
  EXPECT_EQ(score.recall, 1.0);
  EXPECT_EQ(score.average_precision, 1.0);
  EXPECT_EQ(score.position_error_px.p95, 0.0);
}

TEST(StreamingScore, IsThatOfTheNewestEstimateInEachMillisecond) {
  TempFolder folder;
  const DetectorScore score = score_of(folder / "");
  // Nothing before the first packet at 5 ms; from then on 0, 2, 4, 6 and 8 px behind, and 8 px is no inlier.
  EXPECT_DOUBLE_EQ(*score.streaming->recall, (10 + 9 * 3) / 50.0);
  EXPECT_DOUBLE_EQ(*score.streaming->precision, (10 + 9 * 3) / 46.0);
  EXPECT_EQ(score.streaming->latency_median_ms, 0.0);
}

TEST(EventTimeScore, DetectionsHaveARowForEachInstantInTheOrderOfTime) {
  TempFolder folder;
  (void)score_of(folder / "");
  const auto rows = read_table<DetectionRow>(folder / "detections.csv");
  ASSERT_EQ(rows.size(), 50U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].t_us, static_cast<std::int64_t>(i + 1) * 1000);
    EXPECT_EQ(rows[i].circle.x_px, x_px(rows[i].t_us));
  }
}

TEST(StreamingScore, TheTableSaysSinceWhenEachEstimateWasReady) {
  TempFolder folder;
  (void)score_of(folder / "");
  const auto rows = read_table<StreamingRow>(folder / "streaming.csv");
  ASSERT_EQ(rows.size(), 46U);
  for (const StreamingRow& row : rows) {
    EXPECT_EQ(row.ready_us, row.t_us / 5000 * 5000);
    EXPECT_EQ(row.circle.x_px, x_px(row.ready_us));
  }
}

TEST(StreamingScore, HasTheLatenciesOfTheScenario) {
  TempFolder folder;
  // With 5 ms of transport no event is late. Each call has the events of 1 ms and is ready 0.4 ms after their arrival,
  // so that each tick has the estimate that the tick before made, 6 ms behind: 12 px.
  const DetectorScore score = score_of(folder / "", latency_of(LatencyKind::model, 5.0, 400.0));
  EXPECT_DOUBLE_EQ(*score.streaming->latency_median_ms, 5.4);
  EXPECT_DOUBLE_EQ(*score.streaming->latency_p99_ms, 5.4);
  EXPECT_EQ(score.streaming->recall, 0.0);
  for (const StreamingRow& row : read_table<StreamingRow>(folder / "streaming.csv")) {
    EXPECT_EQ(row.ready_us, row.t_us - 600);
    EXPECT_EQ(row.circle.x_px, x_px(row.t_us - 6000));
  }
}

TEST(EventTimeScore, DoesNotDependOnHowLongTransportAndProcessingTake) {
  TempFolder folder;
  const DetectorScore score = score_of(folder / "", latency_of(LatencyKind::model, 5.0, 400.0));
  EXPECT_EQ(score.precision, 1.0);
  EXPECT_EQ(score.position_error_px.p95, 0.0);
  EXPECT_DOUBLE_EQ(*score.recall, 45.0 / 50.0) << "events of the last 5 ms have not arrived";
}

TEST(StreamingScore, OfADetectorThatIsTooSlowHasFewerEstimatesAndTheMetricsSayHowBusyItWas) {
  TempFolder folder;
  const LatencyConfig latency = latency_of(LatencyKind::model, 5.0, 3000.0);
  const Metrics metrics = metrics_of(folder / "", latency);
  ASSERT_TRUE(metrics.latency);
  EXPECT_EQ(metrics.latency->kind, "model");
  EXPECT_NEAR(*metrics.latency->detectors.at(0).busy_ratio, 1.0, 0.1);
  EXPECT_DOUBLE_EQ(*metrics.detectors.at(0).second.streaming->latency_median_ms, 8.0);
  EXPECT_LT(*metrics.detectors.at(0).second.recall, 0.4);
}

TEST(Latency, OfAModelGivesEqualFiguresInEveryRun) {
  TempFolder one, other;
  const LatencyConfig latency = latency_of(LatencyKind::model, 2.0, 1300.0);
  EXPECT_EQ(figures_to_json(metrics_of(one / "", latency)), figures_to_json(metrics_of(other / "", latency)));
}

TEST(Latency, IsWrittenInTheMetricsWhereThereIsOne) {
  TempFolder folder;
  EXPECT_FALSE(metrics_of(folder / "", {}).latency);
  const Metrics metrics = metrics_of(folder / "", latency_of(LatencyKind::measured, 0.0, 0.0));
  const Metrics read = metrics_from_json(metrics_to_json(metrics), "metrics.json");
  ASSERT_TRUE(read.latency);
  EXPECT_EQ(read.latency->kind, "measured");
  EXPECT_GT(*metrics.detectors.at(0).second.streaming->latency_p99_ms, 0.0);
}

TEST(NewestEstimate, StaysWhileEventsMayStillComeAndEndsWithASilenceThatIsKnown) {
  NewestEstimate newest;
  DetectorTick seen;
  seen.observed = seen.on_time = true;
  newest.update(1000, seen, 1000);
  ASSERT_TRUE(newest.ready());
  EXPECT_EQ(newest.ready()->ready_us, 1000);
  newest.update(2000, DetectorTick{}, 1000);
  EXPECT_TRUE(newest.ready()) << "the events of this instant are still to come";
  newest.update(3000, DetectorTick{}, 3000);
  EXPECT_FALSE(newest.ready()) << "there were no events";
}

TEST(ReorderBuffer, PassesTheOldestInstantOnWhereItsEventsNeverCome) {
  ReorderBuffer buffer(1);
  std::vector<std::int64_t> passed;
  for (int i = 1; i <= 20; ++i) {
    buffer.push(i * 1000);
    buffer.pop(0, [&](const auto& instant) { passed.push_back(instant.t_us); });
  }
  EXPECT_THAT(passed, ElementsAre(1000, 2000, 3000, 4000, 5000));
}

}  // namespace
}  // namespace saccade
