// What the window plays and paints, without a window.
#include "apps/view/play.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "apps/view/pixels.h"
#include "apps/view/player.h"
#include "tests/core/streams.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};
const streams::MovingDisc disc{30, 50, 200, 60, 20};

/// A recording of a disc that moves for 0.4 s, and its truth.
class DiscPlay : public testing::Test {
 protected:
  DiscPlay() {
    const auto writer = create_event_file(folder_ / "disc.aedat", image);
    writer->write(std::vector{streams::event_at(0, 127, 127, true)});  // time begins at 0
    writer->write(disc.events(image, 0.4));
    writer->commit();
    TableWriter<TruthRow> truth(folder_ / "truth.csv");
    for (std::int64_t t_us = 0; t_us <= 400'000; t_us += 5'000)
      truth.write({t_us, {disc.x_at(t_us), disc.y_at(t_us), disc.r_px}, 1.0, Eigen::Vector3d::Zero()});
    truth.commit();
    options_.recording = folder_ / "disc.aedat";
    DetectorConfig directed = detector_preset("paper_directed");
    std::get<HoughDetectorConfig>(directed.detector).window.events = 400;
    named_ = {{"paper_directed", directed}, {"best", detector_preset("best")}};
  }
  [[nodiscard]] std::unique_ptr<Play> play() const {
    return play_recording(options_, folder_ / "truth.csv", named_, "paper_directed");
  }
  static void go_to(Play& play, std::int64_t t_us) {
    if (play.watcher().now_us() >= t_us) play.go_back(t_us);
    ASSERT_LT(play.watcher().now_us(), t_us);
    while (play.watcher().now_us() < t_us) ASSERT_TRUE(play.tick());
  }
  static Picture picture_of(Play& play) {
    Picture picture;
    play.fill(picture);
    return picture;
  }

  TempFolder folder_;
  ReadOptions options_;
  NamedDetectors named_;
};

void expect_same(const Picture& a, const Picture& b) {
  EXPECT_EQ(a.now_us, b.now_us);
  EXPECT_EQ(a.events, b.events);
  EXPECT_EQ(a.hough, b.hough);
  ASSERT_EQ(a.seen.size(), b.seen.size());
  for (std::size_t i = 0; i < a.seen.size(); ++i) {
    EXPECT_EQ(a.seen[i].tick.observed, b.seen[i].tick.observed);
    EXPECT_EQ(a.seen[i].tick.estimate.score, b.seen[i].tick.estimate.score);
    EXPECT_EQ(a.seen[i].tick.estimate.circle.x_px, b.seen[i].tick.estimate.circle.x_px);
  }
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_EQ(a.samples[i].t_us, b.samples[i].t_us);
    EXPECT_EQ(a.samples[i].events, b.samples[i].events);
    EXPECT_TRUE(a.samples[i].score == b.samples[i].score || std::isnan(a.samples[i].score));
  }
}

TEST_F(DiscPlay, showsWhatIsSoAndWhatIsFound) {
  const auto play = this->play();
  go_to(*play, 300'000);
  const Picture picture = picture_of(*play);
  ASSERT_TRUE(picture.truth && picture.truth->circle);
  EXPECT_NEAR(picture.truth->circle->x_px, disc.x_at(300'000), 1e-6);
  ASSERT_EQ(picture.seen.size(), 2U);
  EXPECT_EQ(picture.driver, 0U);
  for (const Seen& seen : picture.seen) {
    EXPECT_NEAR(seen.tick.estimate.circle.x_px, disc.x_at(300'000), 6.0) << seen.name;
    EXPECT_NEAR(seen.tick.estimate.circle.y_px, disc.y_at(300'000), 6.0) << seen.name;
  }
  EXPECT_EQ(picture.samples.size(), 300U);
  EXPECT_NEAR(picture.samples.back().truth_px[0], disc.x_at(300'000), 1e-4);
  EXPECT_EQ(picture.hough.size(), static_cast<std::size_t>(image.pixels()));
}

TEST_F(DiscPlay, goesBackToTheSamePicturesAndOnToTheSameOnes) {
  const auto play = this->play();
  go_to(*play, 290'000);
  const Picture early = picture_of(*play);
  go_to(*play, 390'000);
  const Picture late = picture_of(*play);
  for (const std::int64_t t_us : {290'000, 390'000, 100'000, 290'000}) {
    go_to(*play, t_us);
    if (t_us == 290'000) expect_same(picture_of(*play), early);
    if (t_us == 390'000) expect_same(picture_of(*play), late);
  }
}

TEST_F(DiscPlay, endsWithTheRecordingAndGoesBackFromThere) {
  const auto play = this->play();
  while (play->tick()) continue;
  EXPECT_EQ(play->watcher().now_us(), play->watcher().end_us());
  EXPECT_FALSE(play->tick());
  go_to(*play, 50'000);
  EXPECT_EQ(play->watcher().now_us(), 50'000);
}

TEST_F(DiscPlay, aThresholdActsAtOnceAndOnWhatFollows) {
  const auto play = this->play();
  go_to(*play, 300'000);
  const Picture before = picture_of(*play);
  ViewSettings settings = play->settings();
  std::get<HoughDetectorConfig>(settings.detectors[0].config.detector).threshold = 100.0;
  play->apply(settings);
  const Picture after = picture_of(*play);
  EXPECT_EQ(after.now_us, before.now_us);
  EXPECT_EQ(after.seen[0].threshold, 100.0);
  EXPECT_NEAR(after.seen[0].tick.estimate.circle.x_px, before.seen[0].tick.estimate.circle.x_px, 1.5);
  EXPECT_EQ(after.seen[1].tick.estimate.score, before.seen[1].tick.estimate.score);
  go_to(*play, 320'000);
  EXPECT_TRUE(std::isnan(picture_of(*play).samples.back().found_px[0]));
  EXPECT_FALSE(std::isnan(before.samples.back().found_px[0]));

  play->apply([&] {
    ViewSettings first = settings;
    first.detectors[0].config = named_[0].second;
    return first;
  }());
  go_to(*play, 200'000);
  go_to(*play, 300'000);
  const Picture again = picture_of(*play);
  EXPECT_EQ(again.seen[0].tick.estimate.score, before.seen[0].tick.estimate.score);
}

TEST_F(DiscPlay, aDetectorThatIsAddedHasSeenTheLastEvents) {
  const auto play = this->play();
  go_to(*play, 300'000);
  ViewSettings settings = play->settings();
  DetectorConfig full = detector_preset("paper_full");
  std::get<HoughDetectorConfig>(full.detector).window.events = 400;
  settings.detectors.push_back({"mine", full, true});
  settings.detectors[1].on = false;
  settings.driver = 2;
  play->apply(settings);
  const Picture picture = picture_of(*play);
  ASSERT_EQ(picture.seen.size(), 2U);
  EXPECT_EQ(picture.driver, 1U);
  EXPECT_EQ(picture.seen[1].name, "mine");
  EXPECT_NEAR(picture.seen[1].tick.estimate.circle.x_px, disc.x_at(300'000), 6.0);
  go_to(*play, 100'000);
  EXPECT_EQ(picture_of(*play).seen[1].name, "mine");
}

TEST_F(DiscPlay, settingsThatAreWrongChangeNothing) {
  const auto play = this->play();
  go_to(*play, 300'000);
  ViewSettings settings = play->settings();
  std::get<HoughDetectorConfig>(settings.detectors[0].config.detector).radius_px = {30, 10};
  EXPECT_THROW(play->apply(settings), InputError);
  EXPECT_EQ(std::get<HoughDetectorConfig>(play->settings().detectors[0].config.detector).radius_px[0], 10.0);
  EXPECT_TRUE(play->tick());
}

// ---- in a thread of its own ------------------------------------------------------------------------

/// The picture that knows of everything wished so far; to be asked once after each wish.
Picture settled(Player& player) {
  Picture picture;
  while (picture.handled < player.last_wish()) {
    player.take(picture);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return picture;
}

TEST_F(DiscPlay, thePlayerGoesWhereItIsToldAndRestsThere) {
  Player player([&] { return play(); }, false);
  EXPECT_EQ(settled(player).now_us, 0);
  player.seek(250'400);
  EXPECT_EQ(settled(player).now_us, 250'000);
  player.step(10'000);
  EXPECT_EQ(settled(player).now_us, 260'000);
  for (int i = 0; i < 3; ++i) player.step(-1'000);
  EXPECT_EQ(settled(player).now_us, 257'000);
  player.seek(10'000'000);
  const Picture end = settled(player);
  EXPECT_EQ(end.now_us, end.end_us);
  player.seek(-5);
  const Picture start = settled(player);
  EXPECT_EQ(start.now_us, 1'000);
  EXPECT_FALSE(start.playing);
}

TEST_F(DiscPlay, thePlayerPlaysToTheEndAndStops) {
  Player player([&] { return play(); }, true);
  player.set_speed(Player::fastest);
  Picture picture;
  while (picture.playing || picture.now_us < picture.end_us || picture.end_us == 0) {
    player.take(picture);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(picture.now_us, picture.end_us);
  EXPECT_FALSE(picture.playing);
}

TEST_F(DiscPlay, thePlayerTellsWhatIsWrongWithSettingsAndGoesOn) {
  Player player([&] { return play(); }, false);
  player.seek(200'000);
  ViewSettings settings = player.settings();
  std::get<HoughDetectorConfig>(settings.detectors[0].config.detector).threshold = -1.0;
  player.set(settings);
  EXPECT_THAT(settled(player).problem, testing::HasSubstr("threshold"));
  player.set(player.settings());
  EXPECT_EQ(settled(player).problem, "");
}

TEST(PlayerTest, throwsWhatItsPlayThrowsWhereItIsMade) {
  const auto broken = []() -> std::unique_ptr<Play> { throw InputError("place", "this", "that"); };
  EXPECT_THROW(Player(broken, true), InputError);
}

// ---- paint -----------------------------------------------------------------------------------------

Rgb pixel(const RgbImage& rgb, int x, int y) {
  const std::size_t at = 3 * static_cast<std::size_t>(y * image.width + x);
  return {rgb[at], rgb[at + 1], rgb[at + 2]};
}

TEST(Paint, eventsHaveTheColourOfTheirPolarityAndPaleWithAge) {
  Picture picture;
  picture.camera.size = image;
  picture.now_us = 100'000;
  picture.events = {{50'000, 1, 1, true, 0},  {70'000, 2, 1, true, 0},  {90'000, 3, 1, true, 0},
                    {90'000, 4, 1, false, 0}, {95'000, 3, 1, false, 0}, {100'000, 5, 1, true, 0}};
  RgbImage rgb;
  paint_eye(picture, 40'000, true, rgb);
  EXPECT_EQ(pixel(rgb, 1, 1), pixel(rgb, 60, 60)) << "older than shown";
  EXPECT_EQ(pixel(rgb, 5, 1), on_rgb);
  EXPECT_GT(pixel(rgb, 2, 1)[0], pixel(rgb, 60, 60)[0] + 20);
  EXPECT_LT(pixel(rgb, 2, 1)[0], on_rgb[0] - 60);
  EXPECT_GT(pixel(rgb, 4, 1)[2], pixel(rgb, 4, 1)[0] + 50) << "OFF is blue";
  EXPECT_GT(pixel(rgb, 3, 1)[2], pixel(rgb, 3, 1)[0] + 50) << "the newest counts";
}

TEST(Paint, theHoughSpaceIsBrightestWhereItIsStrongest) {
  Picture picture;
  picture.camera.size = image;
  picture.hough.assign(static_cast<std::size_t>(image.pixels()), 0.1F);
  picture.hough[static_cast<std::size_t>(40 * image.width + 30)] = 2.0F;
  RgbImage rgb;
  paint_hough(picture, rgb);
  const auto brightness = [&](int x, int y) {
    const Rgb p = pixel(rgb, x, y);
    return p[0] + p[1] + p[2];
  };
  EXPECT_GT(brightness(30, 40), 500);
  EXPECT_LT(brightness(31, 40), 100);
}

TEST(Paint, theCloudHasThePointsOfTheLastTimeAlone) {
  Picture picture;
  picture.camera.size = image;
  picture.now_us = 100'000;
  const ImageSize size{300, 300};
  RgbImage empty, old, full;
  paint_cloud(picture, 60'000, 0.0, 0.0, size, empty);
  picture.events = {{30'000, 64, 64, true, 0}};
  paint_cloud(picture, 60'000, 0.0, 0.0, size, old);
  EXPECT_EQ(old, empty);
  picture.events.push_back({100'000, 64, 64, true, 0});
  paint_cloud(picture, 60'000, 0.0, 0.0, size, full);
  EXPECT_NE(full, empty);
}

}  // namespace
}  // namespace saccade
