#include "robot/steady_clock.h"

#include <gtest/gtest.h>

namespace saccade {
namespace {

TEST(SteadyClock, StartsAtZeroAndWaitsAtLeastUntilATime) {
  SteadyClock clock;
  const std::int64_t first_us = clock.now_us();
  EXPECT_GE(first_us, 0);
  EXPECT_EQ(clock.wait_until(first_us + 2'000), PortStatus::ok);
  EXPECT_GE(clock.now_us(), first_us + 2'000);
  EXPECT_EQ(clock.wait_until(0), PortStatus::ok) << "has passed";
}

}  // namespace
}  // namespace saccade
