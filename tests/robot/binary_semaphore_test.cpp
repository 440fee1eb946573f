#include "robot/binary_semaphore.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace saccade {
namespace {

using namespace std::chrono_literals;

TEST(BinarySemaphore, RequestsBeforeTheWaitCountAsOne) {
  BinarySemaphore semaphore;
  EXPECT_FALSE(semaphore.wait_for(1ms));
  for (int i = 0; i < 5; ++i) semaphore.request();
  semaphore.wait();
  EXPECT_FALSE(semaphore.wait_for(1ms));
  semaphore.request();
  EXPECT_TRUE(semaphore.wait_for(10s));
}

TEST(BinarySemaphore, RequestsWithoutPauseDoNotKeepTheWaiterFromItsWork) {
  BinarySemaphore semaphore;
  std::atomic<bool> over = false;
  std::thread requests([&] {
    while (!over) semaphore.request();
  });
  for (int i = 0; i < 1000; ++i) semaphore.wait();
  over = true;
  requests.join();
}

TEST(BinarySemaphore, TheNewestValueIsSeenAfterTheLastRequest) {
  constexpr int last = 20'000;
  BinarySemaphore semaphore;
  std::atomic<int> value = 0;
  std::thread writer([&] {
    for (int i = 1; i <= last; ++i) {
      value.store(i, std::memory_order_relaxed);
      semaphore.request();
    }
  });
  do {
    semaphore.wait();
  } while (value.load(std::memory_order_relaxed) < last);
  writer.join();
}

}  // namespace
}  // namespace saccade
