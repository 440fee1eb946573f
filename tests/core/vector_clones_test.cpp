#include "core/vector_clones.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "tests/core/network_bits.h"

namespace saccade_without_clones {
std::vector<std::uint64_t> network_bits();
}

namespace saccade {
namespace {

TEST(VectorClones, NetworksGiveTheSameBitsWithAndWithoutAvx2) {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "this processor has no AVX2";
#endif
  const auto bits = network_bits();
  const auto bits_without = saccade_without_clones::network_bits();
  ASSERT_EQ(bits.size(), bits_without.size());
  std::size_t not_zero = 0;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    ASSERT_TRUE(std::isfinite(std::bit_cast<double>(bits[i]))) << i;
    EXPECT_EQ(bits[i], bits_without[i]) << i;
    not_zero += bits[i] != 0 ? 1U : 0U;
  }
  EXPECT_GT(not_zero, 10'000U) << "of " << bits.size();
}

}  // namespace
}  // namespace saccade
