#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "tests/session/run_over_ticks.h"

namespace saccade {
namespace {

/// Beyond the ticks up to which scores are exact (evaluation/scoring: 2^18) memory is fixed. tests/bench/endurance is the
/// same over 36 million ticks.
TEST(Session, ItsMemoryDoesNotGrowWithTheTicks) {
  constexpr std::int64_t sample_ticks = 150'000;
  std::vector<std::int64_t> rss_kb;
  run_over_ticks(4 * sample_ticks, sample_ticks, [&](std::int64_t done) {
    rss_kb.push_back(resident_kb());
    std::printf("%ld ticks: %ld kB\n", static_cast<long>(done), static_cast<long>(rss_kb.back()));
  });
  ASSERT_EQ(rss_kb.size(), 4u);
  EXPECT_LT(rss_kb[3], rss_kb[2] + 1024) << "150,000 ticks of 8 bytes alone would be more";
}

}  // namespace
}  // namespace saccade
