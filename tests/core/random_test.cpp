#include "core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

namespace saccade {
namespace {

constexpr int samples = 100'000;

TEST(RandomStream, GivesTheSameNumbersOnEveryMachine) {
  const RandomStream random(42, "golden");
  EXPECT_EQ(random.bits(0, 0), 0x1de7135295985275ULL);
  EXPECT_EQ(random.bits(7, 123), 0x6bd25d0107ce84c7ULL);
  EXPECT_EQ(RandomStream(0, "").bits(0), 0x41ca75f8511f94d4ULL);
  EXPECT_EQ(random.uniform(1, 2), 0x1.91110641778b2p-1);
  EXPECT_NEAR(random.normal(1, 2), 0.7834992776, 2e-9);  // Acklam's accuracy
}

TEST(RandomStream, DoesNotDependOnTheOrderOfCalls) {
  const RandomStream a(9, "order");
  const RandomStream b(9, "order");
  const std::uint64_t last = a.bits(3, 1000);
  for (std::uint64_t i = 0; i < 1000; ++i) static_cast<void>(b.bits(i, i));
  EXPECT_EQ(b.bits(3, 1000), last);
}

TEST(RandomStream, IsUniform) {
  const RandomStream random(1, "uniform");
  // Along counters and along streams: chi squared over 64 bins, 63 degrees of freedom, p = 1e-4 at 114.
  for (const bool along_counter : {true, false}) {
    std::array<int, 64> bins{};
    double sum = 0.0;
    for (std::uint64_t i = 0; i < samples; ++i) {
      const double u = along_counter ? random.uniform(5, i) : random.uniform(i, 5);
      ASSERT_GE(u, 0.0);
      ASSERT_LT(u, 1.0);
      ++bins[static_cast<std::size_t>(u * 64)];
      sum += u;
    }
    double chi_squared = 0.0;
    for (const int n : bins) chi_squared += std::pow(n - samples / 64.0, 2) / (samples / 64.0);
    EXPECT_LT(chi_squared, 114.0);
    EXPECT_NEAR(sum / samples, 0.5, 4 * std::sqrt(1.0 / 12 / samples));
  }
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const double u = random.uniform(-3.0, 7.0, 1, i);
    EXPECT_TRUE(u >= -3.0 && u < 7.0);
  }
}

TEST(RandomStream, FlipsHalfOfTheBitsWhenAnyInputChanges) {
  int flipped[4] = {};
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const std::uint64_t bits = RandomStream(i, "a").bits(i, i);
    flipped[0] += std::popcount(bits ^ RandomStream(i, "a").bits(i, i + 1));
    flipped[1] += std::popcount(bits ^ RandomStream(i, "a").bits(i + 1, i));
    flipped[2] += std::popcount(bits ^ RandomStream(i + 1, "a").bits(i, i));
    flipped[3] += std::popcount(bits ^ RandomStream(i, "b").bits(i, i));
  }
  for (const int n : flipped)
    EXPECT_NEAR(n / 2000.0, 32.0, 4 * 4.0 / std::sqrt(2000.0));  // sd of 64 bits is 4
}

TEST(RandomStream, KeepsStreamsIndependent) {
  const RandomStream random(7, "independent");
  const RandomStream other(7, "dependent");
  double with_next_counter = 0.0;
  double with_next_stream = 0.0;
  double with_other_name = 0.0;
  for (std::uint64_t i = 0; i < samples; ++i) {
    const auto centred = [](double u) { return u - 0.5; };
    const double u = centred(random.uniform(3, i));
    with_next_counter += u * centred(random.uniform(3, i + 1));
    with_next_stream += u * centred(random.uniform(4, i));
    with_other_name += u * centred(other.uniform(3, i));
  }
  const double bound = 4.0 / std::sqrt(samples);  // of a correlation coefficient
  EXPECT_LT(std::abs(with_next_counter / samples * 12), bound);
  EXPECT_LT(std::abs(with_next_stream / samples * 12), bound);
  EXPECT_LT(std::abs(with_other_name / samples * 12), bound);
}

TEST(RandomStream, DoesNotRepeatItself) {
  const RandomStream random(3, "repeat");
  std::set<std::uint64_t> seen;
  for (std::uint64_t stream = 0; stream < 200; ++stream) {
    for (std::uint64_t counter = 0; counter < 200; ++counter) seen.insert(random.bits(stream, counter));
  }
  EXPECT_EQ(seen.size(), 40'000U);
}

TEST(RandomStream, IsNormal) {
  const RandomStream random(11, "normal");
  std::vector<double> z;
  double sum = 0.0;
  double square = 0.0;
  for (std::uint64_t i = 0; i < samples; ++i) {
    z.push_back(random.normal(i, 2));
    ASSERT_TRUE(std::isfinite(z.back()));
    sum += z.back();
    square += z.back() * z.back();
  }
  EXPECT_NEAR(sum / samples, 0.0, 4 / std::sqrt(samples));
  EXPECT_NEAR(square / samples, 1.0, 4 * std::sqrt(2.0 / samples));
  // Kolmogorov and Smirnov: p = 1e-4 at 2.23 / sqrt(n).
  std::sort(z.begin(), z.end());
  double apart = 0.0;
  for (int i = 0; i < samples; ++i) {
    const double below = 0.5 * std::erfc(-z[static_cast<std::size_t>(i)] / std::numbers::sqrt2);
    apart = std::max({apart, std::abs(below - static_cast<double>(i) / samples),
                      std::abs(below - static_cast<double>(i + 1) / samples)});
  }
  EXPECT_LT(apart, 2.23 / std::sqrt(samples));
}

TEST(RandomStream, InvertsTheNormalDistributionToItsStatedAccuracy) {
  const RandomStream random(13, "inverse");
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    // The normal of a uniform number is its quantile: back through the distribution gives the number.
    const double back = 0.5 * std::erfc(-random.normal(1, i) / std::numbers::sqrt2);
    ASSERT_NEAR(back, random.uniform(1, i), 2e-9);
  }
}

}  // namespace
}  // namespace saccade
