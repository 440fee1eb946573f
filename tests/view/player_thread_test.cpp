// A playback in a thread of its own, and the actions on it, without a window.
#include "apps/view/player_thread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <optional>
#include <thread>

#include "apps/view/action_handler.h"
#include "apps/view/key_bindings.h"
#include "core/hough/hough_detector.h"
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

/// A detector that cannot be copied, as one in a program of its own; it is made while `works` holds.
struct FragileConfig {};
void describe(FieldVisitor&, FragileConfig&) {}
class Fragile final : public Detector {
 public:
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override { return {}; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }
  [[nodiscard]] std::string_view failure() const override { return "it has no more to say"; }
};
DetectorConfig fragile(const std::atomic<bool>& works) {
  DetectorRegistry registry;
  registry.add(detector_row("fragile", "a program", FragileConfig{},
                            [&works](const FragileConfig&, const Camera&) -> std::unique_ptr<Detector> {
                              if (!works) throw RunError("the program does not start");
                              return std::make_unique<Fragile>();
                            }));
  return registry.config("fragile");
}

TEST_F(PlayerThreadTest, ADetectorThatCannotBeMadeIsReportedAndThePreviousSettingsGoOn) {
  PlayerThread player([&] { return open(); }, false);
  player.seek(200'000);
  settled(player);
  std::atomic<bool> works = false;
  ViewSettings settings = player.settings();
  settings.detectors.push_back({"mine", fragile(works), true});
  settings.selected = 2;
  player.apply(settings);
  EXPECT_THAT(settled(player).problem, testing::HasSubstr("the program does not start"));
  const std::optional<ViewSettings> kept = player.take_kept_settings();
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->detectors.size(), 2U);
  EXPECT_EQ(kept->selected, 0U);
  EXPECT_FALSE(player.take_kept_settings()) << "once";
  player.step(1'000);
  EXPECT_EQ(settled(player).now_us, 201'000);
  works = true;
  player.apply(settings);
  const Snapshot snapshot = settled(player);
  EXPECT_EQ(snapshot.problem, "");
  ASSERT_EQ(snapshot.outputs.size(), 3U);
  EXPECT_EQ(snapshot.outputs[2].failure, "it has no more to say");
  EXPECT_EQ(snapshot.outputs[0].failure, "");
  EXPECT_FALSE(player.take_kept_settings());
}

TEST_F(PlayerThreadTest, ADetectorThatCannotBeMadeAgainLeavesThePlaybackWhereItIs) {
  std::atomic<bool> works = true;
  detectors_.emplace_back("mine", fragile(works));
  PlayerThread player([&] { return open(); }, false);
  player.seek(200'000);
  EXPECT_EQ(settled(player).problem, "");
  works = false;
  player.seek(50'000);
  const Snapshot rejected = settled(player);
  EXPECT_THAT(rejected.problem, testing::HasSubstr("the program does not start"));
  EXPECT_EQ(rejected.now_us, 200'000);
  player.step(3'000);
  EXPECT_EQ(settled(player).now_us, 203'000);
  works = true;
  player.seek(50'000);
  const Snapshot back = settled(player);
  EXPECT_EQ(back.now_us, 50'000);
  EXPECT_EQ(back.problem, "");
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
