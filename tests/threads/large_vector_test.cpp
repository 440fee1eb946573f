#include "threads/large_vector.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>

namespace saccade {
namespace {

TEST(LargeVector, KeepsItsValuesWhileItGrowsFromSmallToLargePages) {
  LargeVector<std::uint32_t> values;
  for (std::size_t count = 1; count < 2'000'000; count *= 3) {
    const std::size_t before = values.size();
    values.resize(count);
    std::iota(values.begin() + static_cast<std::ptrdiff_t>(before), values.end(),
              static_cast<std::uint32_t>(before));
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(values[i], i);
  }
  const LargeVector<std::uint32_t> copy = values;
  EXPECT_EQ(copy, values);
}

TEST(LargeVector, AlignsValuesToACacheLineAndLargeArraysToALargePage) {
  struct alignas(64) Line {
    char bytes[64];
  };
  for (const std::size_t count : {std::size_t{1}, std::size_t{100}, std::size_t{50'000}}) {
    const LargeVector<Line> lines(count);
    const auto address = reinterpret_cast<std::uintptr_t>(lines.data());
    EXPECT_EQ(address % (count > 10'000 ? 2U << 20U : 64U), 0U) << count;
  }
}

}  // namespace
}  // namespace saccade
