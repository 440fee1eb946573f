#include "core/tracker/edge_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

Edge edge(int x, int y, std::int64_t t_us, std::int64_t end_us) {
  Edge e;
  e.t_us = t_us;
  e.end_us = end_us;
  e.x = static_cast<std::uint16_t>(x);
  e.y = static_cast<std::uint16_t>(y);
  return e;
}

std::vector<std::int64_t> times(const EdgeMap& map, std::int64_t now_us) {
  std::vector<std::int64_t> t_us;
  map.for_each(now_us, [&](const Edge& e) { t_us.push_back(e.t_us); });
  return t_us;
}

TEST(EdgeMap, KeepsTheNewestEdgesOfEachRegion) {
  EdgeMap map({20, 12}, 2);
  for (std::int64_t t_us = 1; t_us <= 5; ++t_us) map.add(edge(3, 3, t_us, 100));
  map.add(edge(19, 11, 1, 100));  // a region of its own, cut by the border
  EXPECT_THAT(times(map, 50), UnorderedElementsAre(4, 5, 1));
  EXPECT_EQ(map.capacity(), 3U * 2U * 2U);
}

TEST(EdgeMap, LeavesOutEdgesWhoseLifetimeHasEnded) {
  EdgeMap map({20, 12}, 4);
  EXPECT_EQ(map.last_end_us(), std::numeric_limits<std::int64_t>::min());
  map.add(edge(3, 3, 1, 10));
  map.add(edge(4, 3, 2, 20));
  EXPECT_THAT(times(map, 10), UnorderedElementsAre(1, 2));
  EXPECT_THAT(times(map, 11), ElementsAre(2));
  EXPECT_THAT(times(map, 21), IsEmpty());
  EXPECT_EQ(map.last_end_us(), 20);
}

TEST(EdgeMap, VisitsTheRegionsThatASquareTouches) {
  EdgeMap map({64, 64}, 4);
  map.add(edge(7, 7, 1, 100));
  map.add(edge(8, 7, 2, 100));
  map.add(edge(40, 40, 3, 100));
  const auto near = [&](double x_px, double y_px, double reach_px) {
    std::vector<std::int64_t> t_us;
    map.for_each_near(x_px, y_px, reach_px, 50, [&](const Edge& e) { t_us.push_back(e.t_us); });
    return t_us;
  };
  EXPECT_THAT(near(2, 2, 1), ElementsAre(1));
  EXPECT_THAT(near(7, 2, 1), ElementsAre(1, 2)) << "reaches into the next region";
  EXPECT_THAT(near(44, 44, 2), ElementsAre(3));
  EXPECT_THAT(near(-50, 2, 3), ElementsAre(1)) << "outside the image: its nearest region";
  EXPECT_THAT(near(32, 32, 100), ElementsAre(1, 2, 3));
}

}  // namespace
}  // namespace saccade
