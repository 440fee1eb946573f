#include "robot/binary_semaphore.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace saccade {
namespace {

using namespace std::chrono_literals;

TEST(BinarySemaphore, RequestsBeforeTheWaitCountAsOne) {
  BinarySemaphore wake_up;
  EXPECT_FALSE(wake_up.wait_for(1ms));
  for (int i = 0; i < 5; ++i) wake_up.request();
  wake_up.wait();
  EXPECT_FALSE(wake_up.wait_for(1ms));
  wake_up.request();
  EXPECT_TRUE(wake_up.wait_for(10s));
}

TEST(BinarySemaphore, RequestsWithoutPauseDoNotKeepTheWaiterFromItsWork) {
  BinarySemaphore wake_up;
  std::atomic<bool> over = false;
  std::thread requests([&] {
    while (!over) wake_up.request();
  });
  for (int i = 0; i < 1000; ++i) wake_up.wait();
  over = true;
  requests.join();
}

TEST(BinarySemaphore, TheNewestValueIsSeenAfterTheLastRequest) {
  constexpr int last = 20'000;
  BinarySemaphore wake_up;
  std::atomic<int> value = 0;
  std::thread writer([&] {
    for (int i = 1; i <= last; ++i) {
      value.store(i, std::memory_order_relaxed);
      wake_up.request();
    }
  });
  do {
    wake_up.wait();
  } while (value.load(std::memory_order_relaxed) < last);
  writer.join();
}

}  // namespace
}  // namespace saccade
