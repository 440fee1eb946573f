// Places in the window.
#include "apps/view/layout.h"

#include <gtest/gtest.h>

namespace saccade {
namespace {

constexpr Area zoomed_panel{10, 20, 200, 224};
constexpr ImageSize zoomed_image{100, 100};

TEST(ImageZoom, ThePointUnderTheMouseStays) {
  ImageZoom zoom;
  const Area frame = ViewLayout::below_caption(zoomed_panel);
  const Area before = zoom.place(zoomed_panel, zoomed_image);
  EXPECT_EQ(before.width, 200);
  zoom.scale(2.0F, 50.0F, 80.0F);
  zoom.pan(7.0F, -3.0F);
  const Area after = zoom.place(zoomed_panel, zoomed_image);
  EXPECT_FLOAT_EQ(after.width, 400);
  const float share_x = (frame.x + 50.0F - before.x) / before.width;
  const float share_y = (frame.y + 80.0F - before.y) / before.height;
  EXPECT_FLOAT_EQ(after.x + share_x * after.width, frame.x + 57.0F);
  EXPECT_FLOAT_EQ(after.y + share_y * after.height, frame.y + 77.0F);
}

TEST(ImageZoom, NeitherShrinksTheImageNorMovesAWholeOne) {
  ImageZoom zoom;
  const Area whole = zoom.place(zoomed_panel, zoomed_image);
  const auto is_whole = [&] {
    const Area now = zoom.place(zoomed_panel, zoomed_image);
    return now.x == whole.x && now.y == whole.y && now.width == whole.width && now.height == whole.height;
  };
  zoom.pan(5.0F, 5.0F);
  EXPECT_TRUE(is_whole());
  zoom.scale(0.5F, 20.0F, 20.0F);
  EXPECT_TRUE(is_whole());
  zoom.scale(3.0F, 20.0F, 20.0F);
  EXPECT_FALSE(is_whole());
  zoom.reset();
  EXPECT_TRUE(is_whole());
}

}  // namespace
}  // namespace saccade
