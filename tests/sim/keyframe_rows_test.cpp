#include "sim/keyframe_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

namespace saccade::detail {
namespace {

/// Depths of a row with gaps: 0 where nothing is drawn.
std::vector<float> depths_with_gaps(std::size_t count) {
  std::vector<float> depths;
  for (std::size_t i = 0; i < count; ++i)
    depths.push_back(i % 5 == 3 ? 0.0F : 1.0F + 0.1F * static_cast<float>(i * 7 % 11));
  return depths;
}

TEST(KeyframeRows, LuminanceIsRec709OfWhatIsDrawn) {
  const std::array<std::uint32_t, 4> rgba{0xff0000ffU, 0xff00ff00U, 0xffff0000U, 0xffffffffU};
  const std::array<float, 4> depth{0.5F, 0.5F, 0.5F, 1.0F};
  std::array<std::uint32_t, 4> out{};
  luminance_row(rgba.data(), depth.data(), out.data(), out.size());
  EXPECT_EQ(out, (std::array<std::uint32_t, 4>{2126 * 255, 7152 * 255, 722 * 255, 0}));
}

// Samples 0 to 15 of a row are 100 times their number: so is the mean over the 2.5 samples around each.
TEST(KeyframeRows, MeansLeaveOutAndTakeSharesOfTheSamplesAtTheEnds) {
  std::vector<std::uint32_t> sums{0};
  for (std::uint32_t i = 0; i < 16; ++i) sums.push_back(sums.back() + 100 * i);
  const auto at = [&](int offset) { return sums.data() + offset; };
  const MeanRun run{1, 15, at(-1), at(0), at(1), at(2), 0.25F, 0.75F, 1.0F / 2.5F};
  // .75 of sample i - 1, sample i, .75 of sample i + 1: 250 i.
  std::vector<std::uint32_t> before(16, 7);
  std::vector<std::uint32_t> after(16, 0);
  add_means(std::span(&run, 1), before.data(), after.data());
  std::vector<std::uint16_t> values(16, 0);
  write_means(std::span(&run, 1), values.data());
  for (std::uint32_t i = 1; i < 15; ++i) {
    EXPECT_EQ(after[i], 7 + 100 * i);
    EXPECT_EQ(values[i], 100 * i);
  }
  EXPECT_EQ(after[0], 0) << "outside the run";
  EXPECT_EQ(values[15], 0) << "outside the run";
}

TEST(KeyframeRows, RangeAndStepLeaveOutWhatIsNotDrawn) {
  const std::vector<float> row = depths_with_gaps(37);
  FloatRange range;
  include_row(row.data(), row.size(), range);
  EXPECT_EQ(std::bit_cast<float>(range.most), *std::ranges::max_element(row));
  EXPECT_EQ(std::bit_cast<float>(range.least), 1.0F);
  const std::array<float, 3> a{2.0F, 0.0F, 5.0F};
  const std::array<float, 3> b{2.5F, 9.0F, 0.0F};
  EXPECT_EQ(std::bit_cast<float>(largest_step(a.data(), b.data(), a.size(), 0)), 0.5F);
}

TEST(KeyframeRows, TheLeastOfEachWindow) {
  for (const std::size_t width : {1U, 3U, 9U}) {
    const std::size_t count = 41;
    const std::vector<float> padded = depths_with_gaps(count + width - 1);
    std::vector<float> least(count);
    least_along_row(padded.data(), width, least.data(), count);
    for (std::size_t i = 0; i < count; ++i)
      EXPECT_EQ(least[i], *std::min_element(padded.data() + i, padded.data() + i + width))
          << width << ' ' << i;
  }
}

TEST(KeyframeRows, TheSumOfARowOfAnyLength) {
  for (std::size_t count = 0; count < 20; ++count) {
    const std::vector<float> ones(count, 0.5F);
    EXPECT_EQ(sum_of_row(ones.data(), count), 0.5 * static_cast<double>(count));
  }
}

}  // namespace
}  // namespace saccade::detail
