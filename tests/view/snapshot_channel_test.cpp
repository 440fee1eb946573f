#include "apps/view/snapshot_channel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/view/memory_reader.h"
#include "apps/view/recorded_truth.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

TEST(SnapshotChannel, PassesTheNewestSnapshotOnRequest) {
  SnapshotChannel channel;
  Snapshot shown;
  EXPECT_TRUE(channel.requested());
  EXPECT_FALSE(channel.take(shown)) << "none yet";
  for (const std::int64_t now_us : {1, 2}) {
    channel.back().now_us = now_us;
    channel.publish();
  }
  EXPECT_TRUE(channel.take(shown));
  EXPECT_EQ(shown.now_us, 2);
  EXPECT_TRUE(channel.requested());
  EXPECT_FALSE(channel.take(shown)) << "each once";
  channel.stop();
  EXPECT_FALSE(channel.requested());
}

TEST(MemoryReader, ReadsEventsInBlocks) {
  const std::vector<Event> events = {{1, 2, 3, true, 0}, {2, 3, 4, false, 0}, {3, 4, 5, true, 1}};
  MemoryReader reader(events, {128, 64});
  std::vector<Event> read;
  EXPECT_EQ(reader.read(read, 2), 2U);
  EXPECT_EQ(reader.read(read, 2), 1U);
  EXPECT_EQ(reader.read(read, 2), 0U);
  EXPECT_EQ(read, events);
  EXPECT_EQ(reader.image_size(), (ImageSize{128, 64}));
}

TEST(RecordedTruth, ShowsAnnotatedCirclesForAWhile) {
  const std::vector<TruthRow> rows = {{10'000, {60, 61, 12}, 1.0}, {500'000, {70, 71, 12}, 1.0}};
  const RecordedTruth truth(rows, true, icub_left_2016);
  ASSERT_TRUE(truth.at(10'000).circle);
  EXPECT_EQ(truth.at(10'000).circle->x_px, 60.0);
  EXPECT_FALSE(truth.at(300'000).circle);
  ASSERT_TRUE(truth.at(505'000).circle);
  EXPECT_EQ(truth.at(505'000).circle->x_px, 70.0);
  EXPECT_FALSE(truth.last_us()) << "no rows of gaze";
}

}  // namespace
}  // namespace saccade
