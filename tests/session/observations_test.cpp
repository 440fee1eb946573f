#include "session/observations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "head/icub_cameras.h"
#include "session/session.h"
#include "tests/loop/packet_robot.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::ElementsAre;

/// Reports a circle at the x of the newest event, with that x as score.
class ScoredDetector final : public Detector {
 public:
  void process(std::span<const Event> events, const CameraMotion*) override {
    if (!events.empty()) x_px_ = events.back().x;
  }
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override { return {x_px_ > 0.0, false, {x_px_, 64.0, 20.0}, x_px_}; }
  [[nodiscard]] double threshold() const override { return 20.0; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  double x_px_ = 0.0;
};

Loop loop_with(Robot& robot) {
  std::vector<LoopDetector> detectors;
  detectors.push_back({"scored", std::make_unique<ScoredDetector>()});
  return Loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::nullopt);
}

FakeRobotScript three_events() {
  FakeRobotScript script;
  script.limits = genova02_limits();
  script.events = {{1500, 10, 64, true, 0}, {3500, 20, 64, true, 0}, {3600, 30, 64, true, 0}};
  return script;
}

TEST(Observations, OfARecordingAreThoseOfEachTick) {
  FakeRobot robot(three_events());
  Loop loop = loop_with(robot);
  Observations observations(loop);
  TempFolder folder;
  TableWriter<DetectionRow> table(folder / "detections.csv");
  std::vector<std::int64_t> instants_us;
  class Reader final : public LoopObserver {
   public:
    explicit Reader(std::function<void()> read) : read_(std::move(read)) {}
    void on_tick(const Tick&) override { read_(); }

   private:
    std::function<void()> read_;
  } reader([&] {
    observations.write_completed(table);
    for (const ObservedInstant& instant : observations.completed()) instants_us.push_back(instant.t_us);
  });
  Session session(robot, loop);
  session.add_observer(observations);
  session.add_observer(reader);
  session.run(1000, 5000);
  observations.finish();
  EXPECT_TRUE(observations.completed().empty());
  table.commit();

  EXPECT_THAT(instants_us, ElementsAre(1000, 2000, 3000, 4000, 5000));
  const auto rows = read_table<DetectionRow>(folder / "detections.csv");
  ASSERT_EQ(rows.size(), 2U) << "one row for each tick with an event";
  EXPECT_EQ(rows[0].t_us, 2000);
  EXPECT_EQ(rows[0].detector, "scored");
  EXPECT_EQ(rows[0].score, 10.0);
  EXPECT_EQ(rows[1].t_us, 4000);
  EXPECT_EQ(rows[1].score, 30.0);
}

TEST(DetectorTick, SaysWhetherTheObservationIsAtTheThreshold) {
  FakeRobot robot(three_events());
  Loop loop = loop_with(robot);
  std::vector<std::pair<bool, bool>> ticks;
  class Reader final : public LoopObserver {
   public:
    explicit Reader(std::vector<std::pair<bool, bool>>& ticks) : ticks_(ticks) {}
    void on_tick(const Tick& tick) override {
      ticks_.emplace_back(tick.detectors[0].observed, tick.detectors[0].at_threshold);
    }

   private:
    std::vector<std::pair<bool, bool>>& ticks_;
  } reader(ticks);
  Session session(robot, loop);
  session.add_observer(reader);
  session.run(1000, 5000);
  // The estimate stays valid without events and above the threshold, and is no observation.
  EXPECT_THAT(ticks, ElementsAre(std::pair(false, false), std::pair(true, false), std::pair(false, false),
                                 std::pair(true, true), std::pair(false, false)));
}

TEST(DetectorTick, HeldEstimatesAreObservationsWithoutEvents) {
  DetectorTick tick;
  tick.estimate = {true, true, {64, 64, 20}, 20.0};
  tick.observe(false, 20.0);
  EXPECT_TRUE(tick.observed && tick.at_threshold);
  tick.observe(false, 20.5);
  EXPECT_TRUE(tick.observed);
  EXPECT_FALSE(tick.at_threshold);
  tick.estimate.valid = false;
  tick.observe(true, 0.0);
  EXPECT_FALSE(tick.observed || tick.at_threshold);
}

}  // namespace
}  // namespace saccade
