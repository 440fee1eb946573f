#include "loop/side_threads.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <vector>

namespace saccade {
namespace {

TEST(SideThreads, EveryCallIsMadeOnceHoweverManyThreadsThereAre) {
  for (const std::size_t threads : {1U, 2U, 5U}) {
    SideThreads side(threads);
    for (std::size_t count = 0; count < 40; ++count) {
      std::vector<std::atomic<int>> calls(count);
      const auto job = [&](std::size_t i) { ++calls[i]; };
      side.start(count, job);
      side.finish();
      for (const std::atomic<int>& made : calls)
        ASSERT_EQ(made, 1) << threads << " threads, " << count << " calls";
    }
  }
}

TEST(SideThreads, ACallRunsBesideTheCallingThread) {
  SideThreads side(1);
  std::atomic<bool> begun = false;
  std::atomic<bool> may_end = false;
  const auto job = [&](std::size_t) {
    begun = true;
    begun.notify_one();
    may_end.wait(false);
  };
  side.start(1, job);
  begun.wait(false);  // would wait for ever if the call waited for finish()
  may_end = true;
  may_end.notify_one();
  side.finish();
}

TEST(SideThreads, WhatACallWroteIsThereAfterFinish) {
  SideThreads side(3);
  std::array<std::size_t, 64> squares{};
  for (int round = 0; round < 200; ++round) {
    squares.fill(0);
    const auto job = [&](std::size_t i) { squares[i] = i * i; };
    side.start(squares.size(), job);
    side.finish();
    for (std::size_t i = 0; i < squares.size(); ++i) ASSERT_EQ(squares[i], i * i);
  }
}

TEST(SideThreads, WithoutCallsThereIsNothingToWaitFor) {
  SideThreads side(2);
  side.finish();
  side.start(0, [](std::size_t) {});
  side.finish();
}

}  // namespace
}  // namespace saccade
