// Checkpoints of a recording's playback.
#include "apps/view/checkpoints.h"
#include "apps/view/loop_history.h"
#include "head/icub_cameras.h"

#include <gtest/gtest.h>

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};

TEST(Checkpoints, TheLimitHoldsForNoDetectorsAndForEmptyImages) {
  EXPECT_EQ(Checkpoints::limit(image, 0), 64U);
  EXPECT_EQ(Checkpoints::limit({0, 0}, 2), 64U);
  EXPECT_EQ(Checkpoints::limit(image, 2), 64U);
  EXPECT_EQ(Checkpoints::limit({1280, 720}, 3), 3U);
}

LoopHistory history_at(std::int64_t now_us) {
  Camera camera = icub_left_2016;
  camera.size = {1280, 720};
  return {camera, Eye::left, now_us, 100'000'000};
}

TEST(Checkpoints, TooManyAreThinnedOutAndTheStartRemains) {
  Checkpoints checkpoints(history_at(0));
  std::int64_t now_us = 0;
  for (int added = 0; added < 150; now_us += 1'000) {
    if (!checkpoints.due(now_us)) continue;
    checkpoints.add(history_at(now_us), {});
    ++added;
  }
  EXPECT_EQ(checkpoints.start().history.now_us(), 0);
  EXPECT_EQ(checkpoints.latest_before(1).history.now_us(), 0);
  // At most 64 of them are spaced over all of the time.
  const std::int64_t middle_us = checkpoints.latest_before(now_us / 2).history.now_us();
  EXPECT_LT(middle_us, now_us / 2);
  EXPECT_GT(middle_us, now_us / 2 - now_us / 25);
  checkpoints.clear();
  EXPECT_EQ(checkpoints.latest_before(now_us).history.now_us(), 0);
}

TEST(Checkpoints, AreSortedByTimeWhereALaterInstantWasReachedFirst) {
  Checkpoints checkpoints(history_at(0));
  checkpoints.add(history_at(9'000'000), {});
  EXPECT_FALSE(checkpoints.due(9'000'000));
  EXPECT_TRUE(checkpoints.due(4'000'000)) << "far from both";
  checkpoints.add(history_at(4'000'000), {});
  EXPECT_FALSE(checkpoints.due(4'000'000 + Checkpoints::first_spacing_us - 1));
  EXPECT_TRUE(checkpoints.due(4'000'000 + Checkpoints::first_spacing_us));
  EXPECT_EQ(checkpoints.latest_before(5'000'000).history.now_us(), 4'000'000);
  EXPECT_EQ(checkpoints.latest_before(4'000'000).history.now_us(), 0);
  EXPECT_EQ(checkpoints.latest_before(10'000'000).history.now_us(), 9'000'000);
}

}  // namespace
}  // namespace saccade
