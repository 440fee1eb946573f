#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "tests/session/run_over_ticks.h"

namespace saccade {
namespace {

/// Some 700,000 ticks after scores begin to be approximate (evaluation/scoring: from 2^18 on) memory is fixed. tests/bench/endurance is the
/// same over 36 million ticks.
TEST(Session, ItsMemoryDoesNotGrowWithTheTicks) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer keeps freed memory";
#endif
  constexpr std::int64_t sample_ticks = 400'000;
  std::vector<std::int64_t> rss_kb;
  run_over_ticks(3 * sample_ticks, sample_ticks, [&](std::int64_t done) {
    rss_kb.push_back(resident_kb());
    std::printf("%ld ticks: %ld kB\n", static_cast<long>(done), static_cast<long>(rss_kb.back()));
  });
  ASSERT_EQ(rss_kb.size(), 3u);
  EXPECT_LT(rss_kb[2], rss_kb[1] + 3'000) << "400,000 ticks of 8 bytes alone would be more";
}

}  // namespace
}  // namespace saccade
