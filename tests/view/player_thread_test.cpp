// A playback in a thread of its own, and the actions on it, without a window.
#include "apps/view/player_thread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "apps/view/action_handler.h"
#include "apps/view/key_bindings.h"
#include "core/hough_detector.h"
#include "tests/view/disc_recording.h"

namespace saccade {
namespace {

class PlayerThreadTest : public DiscRecording {};

/// The first snapshot that includes all requests so far.
Snapshot settled(PlayerThread& player) {
  Snapshot snapshot;
  while (snapshot.request < player.last_request()) {
    player.take(snapshot);
    std::this_thread::yield();
  }
  return snapshot;
}

TEST_F(PlayerThreadTest, SeeksAndStepsToTheRequestedTimeAndPausesThere) {
  PlayerThread player([&] { return open(); }, false);
  EXPECT_EQ(settled(player).now_us, 0);
  player.seek(250'400);
  EXPECT_EQ(settled(player).now_us, 250'000);
  player.step(10'000);
  EXPECT_EQ(settled(player).now_us, 260'000);
  for (int i = 0; i < 3; ++i) player.step(-1'000);
  EXPECT_EQ(settled(player).now_us, 257'000);
  player.seek(10'000'000);
  const Snapshot end = settled(player);
  EXPECT_EQ(end.now_us, end.end_us);
  player.seek(-5);
  const Snapshot start = settled(player);
  EXPECT_EQ(start.now_us, 1'000);
  EXPECT_FALSE(start.playing);
}

TEST_F(PlayerThreadTest, PlaysToTheEndAndStops) {
  PlayerThread player([&] { return open(); }, true);
  player.set_speed(PlayerThread::unlimited_speed);
  Snapshot snapshot;
  while (snapshot.playing || snapshot.now_us < snapshot.end_us || snapshot.end_us == 0) {
    player.take(snapshot);
    std::this_thread::yield();
  }
  EXPECT_EQ(snapshot.now_us, snapshot.end_us);
  EXPECT_FALSE(snapshot.playing);
}

TEST_F(PlayerThreadTest, ReportsInvalidSettingsAndContinues) {
  PlayerThread player([&] { return open(); }, false);
  player.seek(200'000);
  settled(player);
  ViewSettings settings = player.settings();
  settings.detectors[0].config.get<HoughDetectorConfig>().threshold = -1.0;
  player.apply(settings);
  EXPECT_THAT(settled(player).problem, testing::HasSubstr("threshold"));
  player.apply(player.settings());
  EXPECT_EQ(settled(player).problem, "");
}

TEST_F(PlayerThreadTest, ThePlayerCanBeUsedWhileThePlaybackIsStillBeingMade) {
  std::promise<void> go;
  PlayerThread player(
      [&] {
        go.get_future().wait();
        return open();
      },
      true);
  EXPECT_FALSE(player.ready());
  Snapshot snapshot;
  EXPECT_FALSE(player.take(snapshot));
  player.play(false);
  player.seek(200'000);
  go.set_value();
  EXPECT_EQ(settled(player).now_us, 200'000);
  EXPECT_TRUE(player.ready());
}

TEST_F(PlayerThreadTest, ReadyThrowsTheErrorOfAPlaybackThatCannotBeMade) {
  PlayerThread player([]() -> std::unique_ptr<Playback> { throw InputError("place", "this", "that"); }, true);
  const auto wait = [&] {
    while (!player.ready()) std::this_thread::yield();
  };
  EXPECT_THROW(wait(), InputError);
}

TEST_F(PlayerThreadTest, EveryActionLeavesAPlaybackWithoutDetectorsRunning) {
  detectors_.clear();
  PlayerThread player([&] { return open(); }, false);
  Snapshot snapshot = settled(player);
  ViewState state;
  state.with_playback = true;
  state.settings = player.settings();
  for (const KeyBinding& binding : key_bindings()) {
    for (const KeyAction& key : binding.actions) apply_action(key.action, snapshot, state, &player);
  }
  player.play(false);
  player.seek(200'000);
  snapshot = settled(player);
  EXPECT_EQ(snapshot.now_us, 200'000);
  EXPECT_EQ(snapshot.problem, "");
}

TEST_F(PlayerThreadTest, AThresholdStaysWithinItsRange) {
  PlayerThread player([&] { return open(); }, false);
  const Snapshot snapshot = settled(player);
  ViewState state;
  state.with_playback = true;
  state.settings = player.settings();
  const auto threshold = [&] {
    return state.settings.detectors[0].config.get<HoughDetectorConfig>().threshold;
  };
  const double first = threshold();
  apply_action({Action::Type::scale_threshold, 1}, snapshot, state, &player);
  EXPECT_NEAR(threshold(), 1.1 * first, 1e-9);
  for (int i = 0; i < 1000; ++i) apply_action({Action::Type::scale_threshold, 1}, snapshot, state, &player);
  EXPECT_EQ(settled(player).problem, "");
}

}  // namespace
}  // namespace saccade
