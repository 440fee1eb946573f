// Images that the window paints, without a window.
#include "apps/view/images.h"

#include <gtest/gtest.h>

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};

Rgb pixel(const RgbImage& rgb, int x, int y) {
  const std::size_t at = 3 * static_cast<std::size_t>(y * image.width + x);
  return {rgb[at], rgb[at + 1], rgb[at + 2]};
}

TEST(Images, EventsHaveTheColourOfTheirPolarityAndFadeWithAge) {
  Snapshot snapshot;
  snapshot.camera.size = image;
  snapshot.now_us = 100'000;
  snapshot.events = {{50'000, 1, 1, true, 0},  {70'000, 2, 1, true, 0},  {90'000, 3, 1, true, 0},
                     {90'000, 4, 1, false, 0}, {95'000, 3, 1, false, 0}, {100'000, 5, 1, true, 0}};
  RgbImage rgb;
  paint_eye(snapshot, 40'000, true, rgb);
  EXPECT_EQ(pixel(rgb, 1, 1), pixel(rgb, 60, 60)) << "older than shown";
  EXPECT_EQ(pixel(rgb, 5, 1), on_rgb);
  EXPECT_GT(pixel(rgb, 2, 1)[0], pixel(rgb, 60, 60)[0] + 20);
  EXPECT_LT(pixel(rgb, 2, 1)[0], on_rgb[0] - 60);
  EXPECT_GT(pixel(rgb, 4, 1)[2], pixel(rgb, 4, 1)[0] + 50) << "OFF is blue";
  EXPECT_GT(pixel(rgb, 3, 1)[2], pixel(rgb, 3, 1)[0] + 50) << "the newest counts";
}

TEST(Images, TheHoughSpaceIsBrightestAtItsMaximum) {
  Snapshot snapshot;
  snapshot.camera.size = image;
  snapshot.hough.assign(static_cast<std::size_t>(image.pixels()), 0.1F);
  snapshot.hough[static_cast<std::size_t>(40 * image.width + 30)] = 2.0F;
  RgbImage rgb;
  paint_hough(snapshot, rgb);
  const auto brightness = [&](int x, int y) {
    const Rgb p = pixel(rgb, x, y);
    return p[0] + p[1] + p[2];
  };
  EXPECT_GT(brightness(30, 40), 500);
  EXPECT_LT(brightness(31, 40), 100);
}

TEST(Images, TheEventCloudShowsTheLastEventsAlone) {
  Snapshot snapshot;
  snapshot.camera.size = image;
  snapshot.now_us = 100'000;
  const ImageSize size{300, 300};
  RgbImage empty, old, full;
  paint_event_cloud(snapshot, 60'000, 0.0, 0.0, size, empty);
  snapshot.events = {{30'000, 64, 64, true, 0}};
  paint_event_cloud(snapshot, 60'000, 0.0, 0.0, size, old);
  EXPECT_EQ(old, empty);
  snapshot.events.push_back({100'000, 64, 64, true, 0});
  paint_event_cloud(snapshot, 60'000, 0.0, 0.0, size, full);
  EXPECT_NE(full, empty);
}

}  // namespace
}  // namespace saccade
