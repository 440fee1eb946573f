#include "core/time_surface.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace saccade {
namespace {

constexpr ImageSize surface_image{5, 3};

std::int64_t at(const TimeSurface& surface, int x, int y, bool on) {
  return surface.newest_us(on)[static_cast<std::size_t>(y * surface_image.width + x)];
}

TEST(TimeSurface, HasNoTimesBeforeTheFirstEvent) {
  const TimeSurface surface(surface_image);
  for (const bool on : {false, true}) {
    const auto times = surface.newest_us(on);
    ASSERT_EQ(times.size(), 15U);
    EXPECT_TRUE(std::ranges::all_of(times, [](std::int64_t t_us) { return t_us == TimeSurface::never_us; }));
  }
}

TEST(TimeSurface, KeepsTheNewestTimeOfEachPixelAndPolarity) {
  TimeSurface surface(surface_image);
  surface.add({-7, 0, 0, true, 0});
  surface.add({10, 4, 2, true, 0});
  surface.add({20, 4, 2, false, 0});
  surface.add({30, 4, 2, true, 0});
  EXPECT_EQ(at(surface, 0, 0, true), -7);
  EXPECT_EQ(at(surface, 4, 2, true), 30);
  EXPECT_EQ(at(surface, 4, 2, false), 20);
  EXPECT_EQ(at(surface, 0, 0, false), TimeSurface::never_us);
  EXPECT_EQ(at(surface, 3, 2, true), TimeSurface::never_us);
}

TEST(TimeSurface, IsNotChangedByPrefetching) {
  TimeSurface surface(surface_image);
  surface.prefetch({99, 1, 1, true, 0});
  EXPECT_EQ(at(surface, 1, 1, true), TimeSurface::never_us);
}

}  // namespace
}  // namespace saccade
