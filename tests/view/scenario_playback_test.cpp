// Playback of a simulated scenario and the feed of a run, without a window.
#include <gtest/gtest.h>

#include <optional>

#include "apps/view/playback.h"
#include "apps/view/run_feed.h"
#include "config/scenario.h"
#include "core/detectors/built_in_detectors.h"
#include "session/scenario_loop.h"
#include "sim/sim_robot.h"
#include "tests/config/built_in.h"

namespace saccade {
namespace {

Scenario scenario(const std::string& name, std::vector<std::string> assignments = {}) {
  assignments.emplace_back("render.supersampling=1");
  return read_scenario(std::string(SACCADE_SOURCE_DIR) + "/scenarios/" + name, assignments, std::nullopt,
                       built_in());
}

Snapshot snapshot_of(Playback& playback) {
  Snapshot snapshot;
  playback.fill(snapshot);
  return snapshot;
}

/// Whether the model can still be read: a body's name, and the size of a state of it.
void expect_readable(const Snapshot& snapshot) {
  ASSERT_TRUE(snapshot.model);
  ASSERT_TRUE(snapshot.scene);
  EXPECT_GE(mj_name2id(snapshot.model.get(), mjOBJ_GEOM, "ball"), 0);
  EXPECT_EQ(snapshot.scene->nbuffer, MjDataPtr(mj_makeData(snapshot.model.get()))->nbuffer);
}

TEST(ScenarioPlayback, SnapshotsKeepTheirModelAcrossRestartsAndAfterThePlayback) {
  auto playback = make_scenario_playback(scenario("look_at_ball.yaml"));
  playback->tick();
  const Snapshot first = snapshot_of(*playback);
  playback->restore_before(0);
  playback->tick();
  const Snapshot second = snapshot_of(*playback);
  playback->restore_before(0);
  const Snapshot third = snapshot_of(*playback);
  EXPECT_EQ(first.model, second.model) << "one model for all restarts";
  EXPECT_EQ(first.model, third.model);
  playback.reset();
  for (const Snapshot* snapshot : {&first, &second, &third}) expect_readable(*snapshot);
}

TEST(ScenarioPlayback, JointsOfThePlotsAreThoseOfTheHead) {
  const auto pan_tilt = make_scenario_playback(scenario("gaze_square_pan_tilt.yaml"));
  pan_tilt->tick();
  pan_tilt->tick();
  EXPECT_EQ(snapshot_of(*pan_tilt).joint_names, (std::vector<std::string>{"pan", "tilt"}));
  const auto icub = make_scenario_playback(scenario("look_at_ball.yaml"));
  icub->tick();
  icub->tick();
  EXPECT_EQ(snapshot_of(*icub).joint_names,
            (std::vector<std::string>{"neck_pitch", "neck_roll", "neck_yaw", "eyes_tilt", "eyes_version",
                                      "eyes_vergence"}));
}

TEST(ScenarioPlayback, RestoringTheStartReproducesTheRun) {
  const auto playback = make_scenario_playback(scenario("look_at_ball.yaml"));
  for (int i = 0; i < 30; ++i) playback->tick();
  const Snapshot first = snapshot_of(*playback);
  playback->restore_before(1);
  EXPECT_EQ(playback->history().now_us(), 0);
  for (int i = 0; i < 30; ++i) playback->tick();
  const Snapshot again = snapshot_of(*playback);
  EXPECT_EQ(again.now_us, first.now_us);
  EXPECT_EQ(again.events, first.events);
  EXPECT_EQ(again.grey, first.grey);
  EXPECT_EQ(again.hough, first.hough);
}

TEST(ScenarioPlayback, TheShippedScenarioWithoutDetectorsPlays) {
  const auto playback = make_scenario_playback(scenario("calibrate_left.yaml", {"run.duration_s=0.05"}));
  while (playback->tick()) continue;
  const Snapshot snapshot = snapshot_of(*playback);
  EXPECT_EQ(snapshot.now_us, 50'000);
  EXPECT_EQ(snapshot.selected_output(), nullptr);
  EXPECT_TRUE(snapshot.hough.empty());
  EXPECT_FALSE(snapshot.grey.empty());

  ViewSettings settings = playback->settings();
  EXPECT_EQ(settings.selected_detector(), nullptr);
  playback->apply(settings);
  settings.detectors.push_back({"best", built_in_detectors().config("best"), true});
  playback->apply(settings);
  playback->restore_before(0);
  playback->tick();
  ASSERT_NE(snapshot_of(*playback).selected_output(), nullptr);
  EXPECT_EQ(snapshot_of(*playback).selected_output()->name, "best");
}

TEST(RunFeed, ASnapshotOutlivesARunThatThrows) {
  const Scenario run = scenario("look_at_ball.yaml");
  RunFeed feed(run);
  Snapshot snapshot;
  const auto failing_run = [&] {
    SimRobot robot(run.sim, static_cast<std::uint64_t>(run.seed));
    Loop loop = make_loop(run, robot);
    struct Observer final : LoopObserver {
      Observer(RunFeed& its_feed, SimRobot& its_robot, Loop& its_loop)
          : feed(its_feed), robot(its_robot), loop(its_loop) {}
      void on_tick(const Tick& tick) override { feed.record(tick, robot, loop); }
      RunFeed& feed;
      SimRobot& robot;
      Loop& loop;
    } observer(feed, robot, loop);
    loop.tick(World::tick_us, observer);
    throw RunError("the disk is full");
  };
  EXPECT_THROW(failing_run(), RunError);
  ASSERT_TRUE(feed.channel().take(snapshot));
  expect_readable(snapshot);
}

}  // namespace
}  // namespace saccade
