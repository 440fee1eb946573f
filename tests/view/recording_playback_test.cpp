// Playback of a recording, without a window.
#include "apps/view/playback.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/detectors/built_in_detectors.h"
#include "core/hough/hough_detector.h"
#include "tests/view/disc_recording.h"

namespace saccade {
namespace {

void expect_same(const Snapshot& a, const Snapshot& b) {
  EXPECT_EQ(a.now_us, b.now_us);
  EXPECT_EQ(a.events, b.events);
  EXPECT_EQ(a.hough, b.hough);
  ASSERT_EQ(a.outputs.size(), b.outputs.size());
  for (std::size_t i = 0; i < a.outputs.size(); ++i) {
    EXPECT_EQ(a.outputs[i].tick.observed, b.outputs[i].tick.observed);
    EXPECT_EQ(a.outputs[i].tick.estimate.score, b.outputs[i].tick.estimate.score);
    EXPECT_EQ(a.outputs[i].tick.estimate.circle.x_px, b.outputs[i].tick.estimate.circle.x_px);
  }
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_EQ(a.samples[i].t_us, b.samples[i].t_us);
    EXPECT_EQ(a.samples[i].events, b.samples[i].events);
    EXPECT_TRUE(a.samples[i].score == b.samples[i].score || std::isnan(a.samples[i].score));
  }
}

TEST_F(DiscRecording, ASnapshotHoldsGroundTruthAndDetections) {
  const auto playback = open();
  seek(*playback, 300'000);
  const Snapshot snapshot = snapshot_of(*playback);
  ASSERT_TRUE(snapshot.truth && snapshot.truth->circle);
  EXPECT_NEAR(snapshot.truth->circle->x_px, disc.x_at(300'000), 1e-6);
  ASSERT_EQ(snapshot.outputs.size(), 2U);
  EXPECT_EQ(snapshot.selected, 0U);
  for (const DetectorOutput& output : snapshot.outputs) {
    EXPECT_NEAR(output.tick.estimate.circle.x_px, disc.x_at(300'000), 6.0) << output.name;
    EXPECT_NEAR(output.tick.estimate.circle.y_px, disc.y_at(300'000), 6.0) << output.name;
  }
  EXPECT_EQ(snapshot.samples.size(), 300U);
  EXPECT_NEAR(snapshot.samples.back().truth_px[0], disc.x_at(300'000), 1e-4);
  EXPECT_EQ(snapshot.hough.size(), static_cast<std::size_t>(image.pixels()));
}

TEST_F(DiscRecording, SeekingBackAndForthReproducesTheSameSnapshots) {
  const auto playback = open();
  seek(*playback, 290'000);
  const Snapshot early = snapshot_of(*playback);
  seek(*playback, 390'000);
  const Snapshot late = snapshot_of(*playback);
  for (const std::int64_t t_us : {290'000, 390'000, 100'000, 290'000}) {
    seek(*playback, t_us);
    if (t_us == 290'000) expect_same(snapshot_of(*playback), early);
    if (t_us == 390'000) expect_same(snapshot_of(*playback), late);
  }
}

/// A detector without DetectorViews.
class PlainDetector final : public Detector {
 public:
  PlainDetector(const HoughDetectorConfig& config, ImageSize size) : detector_(config, size) {}
  void process(std::span<const Event> events, const CameraMotion* motion) override {
    detector_.process(events, motion);
  }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    detector_.advance_to(now_us, motion);
  }
  [[nodiscard]] Estimate estimate() override { return detector_.estimate(); }
  [[nodiscard]] double threshold() const override { return detector_.threshold(); }
  [[nodiscard]] RejectedEvents rejected() const override { return detector_.rejected(); }

 private:
  HoughDetector detector_;
};

TEST_F(DiscRecording, SeekingBackWithADetectorThatCannotBeCopiedReproducesTheSameSnapshots) {
  DetectorRegistry registry;
  registry.add(detector_row("plain", "for this test", detectors_[0].second.get<HoughDetectorConfig>(),
                            [](const HoughDetectorConfig& config, const Camera& camera) {
                              return std::make_unique<PlainDetector>(config, camera.size);
                            }));
  detectors_ = {{"plain", registry.config("plain")}};
  const auto playback = open();
  seek(*playback, 290'000);
  const Snapshot early = snapshot_of(*playback);
  EXPECT_TRUE(early.hough.empty());
  ASSERT_TRUE(early.outputs[0].tick.estimate.valid);
  seek(*playback, 390'000);
  seek(*playback, 290'000);
  expect_same(snapshot_of(*playback), early);
  playback->apply(playback->settings());
  EXPECT_EQ(snapshot_of(*playback).outputs[0].tick.estimate.score, early.outputs[0].tick.estimate.score);
}

TEST_F(DiscRecording, TickingEndsWithTheRecordingAndSeekingBackWorksFromTheEnd) {
  const auto playback = open();
  while (playback->tick()) continue;
  EXPECT_EQ(playback->history().now_us(), playback->history().end_us());
  EXPECT_FALSE(playback->tick());
  seek(*playback, 50'000);
  EXPECT_EQ(playback->history().now_us(), 50'000);
}

TEST_F(DiscRecording, AChangedThresholdTakesEffectAtOnceAndInTheTicksThatFollow) {
  const auto playback = open();
  seek(*playback, 300'000);
  const Snapshot before = snapshot_of(*playback);
  ViewSettings settings = playback->settings();
  settings.detectors[0].config.get<HoughDetectorConfig>().threshold = 100.0;
  playback->apply(settings);
  const Snapshot after = snapshot_of(*playback);
  EXPECT_EQ(after.now_us, before.now_us);
  EXPECT_EQ(after.outputs[0].threshold, 100.0);
  EXPECT_NEAR(after.outputs[0].tick.estimate.circle.x_px, before.outputs[0].tick.estimate.circle.x_px, 1.5);
  EXPECT_EQ(after.outputs[1].tick.estimate.score, before.outputs[1].tick.estimate.score);
  seek(*playback, 320'000);
  EXPECT_TRUE(std::isnan(snapshot_of(*playback).samples.back().detected_px[0]));
  EXPECT_FALSE(std::isnan(before.samples.back().detected_px[0]));

  playback->apply([&] {
    ViewSettings first = settings;
    first.detectors[0].config = detectors_[0].second;
    return first;
  }());
  seek(*playback, 200'000);
  seek(*playback, 300'000);
  const Snapshot again = snapshot_of(*playback);
  EXPECT_EQ(again.outputs[0].tick.estimate.score, before.outputs[0].tick.estimate.score);
}

TEST_F(DiscRecording, AnAddedDetectorHasProcessedTheLastEvents) {
  const auto playback = open();
  seek(*playback, 300'000);
  ViewSettings settings = playback->settings();
  DetectorConfig full = built_in_detectors().config("paper_full");
  full.get<HoughDetectorConfig>().window.events = 400;
  settings.detectors.push_back({"mine", full, true});
  settings.detectors[1].enabled = false;
  settings.selected = 2;
  playback->apply(settings);
  const Snapshot snapshot = snapshot_of(*playback);
  ASSERT_EQ(snapshot.outputs.size(), 2U);
  EXPECT_EQ(snapshot.selected, 1U);
  EXPECT_EQ(snapshot.outputs[1].name, "mine");
  EXPECT_NEAR(snapshot.outputs[1].tick.estimate.circle.x_px, disc.x_at(300'000), 6.0);
  seek(*playback, 100'000);
  EXPECT_EQ(snapshot_of(*playback).outputs[1].name, "mine");
}

TEST_F(DiscRecording, InvalidSettingsAreRejectedAndChangeNothing) {
  const auto playback = open();
  seek(*playback, 300'000);
  ViewSettings settings = playback->settings();
  settings.detectors[0].config.get<HoughDetectorConfig>().radius_px = {30, 10};
  EXPECT_THROW(playback->apply(settings), InputError);
  EXPECT_EQ(playback->settings().detectors[0].config.get<HoughDetectorConfig>().radius_px[0], 10.0);
  EXPECT_TRUE(playback->tick());
}

TEST_F(DiscRecording, PlaysWithoutDetectorsAndTakesOneLater) {
  detectors_.clear();
  const auto playback = open();
  seek(*playback, 300'000);
  Snapshot snapshot = snapshot_of(*playback);
  EXPECT_TRUE(snapshot.outputs.empty());
  EXPECT_EQ(snapshot.selected_output(), nullptr);
  EXPECT_TRUE(snapshot.hough.empty());
  seek(*playback, 100'000);
  EXPECT_EQ(playback->history().now_us(), 100'000);

  ViewSettings settings = playback->settings();
  EXPECT_EQ(settings.selected_detector(), nullptr);
  settings.detectors.push_back({"best", built_in_detectors().config("best"), true});
  playback->apply(settings);
  seek(*playback, 300'000);
  snapshot = snapshot_of(*playback);
  ASSERT_NE(snapshot.selected_output(), nullptr);
  EXPECT_NEAR(snapshot.selected_output()->tick.estimate.circle.x_px, disc.x_at(300'000), 6.0);
}

}  // namespace
}  // namespace saccade
