#include "robot/latest_value.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace saccade {
namespace {

TEST(LatestValue, GivesTheValueThatWasWrittenLast) {
  LatestValue<double> cell(1.5);
  EXPECT_EQ(cell.read(), 1.5);
  for (int i = 0; i < 10; ++i) cell.write(i);
  EXPECT_EQ(cell.read(), 9.0);
  EXPECT_EQ(cell.count(), 11u);
}

TEST(LatestValue, ReadersNeverSeeHalfOfAValueAndNeverAnOlderOneAgain) {
  struct Wide {
    std::int64_t number[24] = {};
  };
  LatestValue<Wide> cell;
  std::atomic<bool> over = false;
  std::thread writer([&] {
    for (std::int64_t n = 1; !over; ++n) {
      Wide value;
      for (std::int64_t& number : value.number) number = n;
      cell.write(value);
    }
  });
  std::int64_t newest = 0;
  for (int i = 0; i < 200'000; ++i) {
    const Wide value = cell.read();
    for (const std::int64_t number : value.number) ASSERT_EQ(number, value.number[0]);
    ASSERT_GE(value.number[0], newest);
    newest = value.number[0];
  }
  over = true;
  writer.join();
}

}  // namespace
}  // namespace saccade
