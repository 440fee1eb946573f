#include "emulator/band_threads.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

namespace saccade {
namespace {

class BandThreadsOf : public testing::TestWithParam<std::size_t> {};

TEST_P(BandThreadsOf, RunEachBandOnceAndReturnWhenAllAreDone) {
  BandThreads threads(GetParam());
  ASSERT_EQ(threads.bands(), GetParam());
  std::vector<int> sums(threads.bands());
  for (int i = 1; i <= 20'000; ++i) {
    // Awake, asleep, and going to sleep while a job begins.
    if (i % 100 == 0) threads.wake();
    if (i % 100 == 50) threads.rest();
    if (i % 5'000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    threads.run([&](std::size_t band) { sums[band] += i; });
    ASSERT_EQ(sums, std::vector<int>(threads.bands(), sums.front())) << i;
  }
  EXPECT_EQ(sums.front(), 20'000 * 20'001 / 2);
}

INSTANTIATE_TEST_SUITE_P(OneToFour, BandThreadsOf, testing::Values(1, 2, 4));

TEST(BandThreads, EndWithoutAJobAwakeAndAsleep) {
  { const BandThreads asleep(3); }
  BandThreads awake(3);
  awake.wake();
}

}  // namespace
}  // namespace saccade
