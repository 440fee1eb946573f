#include "threads/worker_threads.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace saccade {
namespace {

class WorkerThreadsOf : public testing::TestWithParam<std::size_t> {};

TEST_P(WorkerThreadsOf, RunEachCallOnceAndReturnWhenAllAreDone) {
  WorkerThreads threads(GetParam());
  ASSERT_EQ(threads.threads(), GetParam());
  std::vector<int> sums(threads.threads());
  for (int i = 1; i <= 20'000; ++i) {
    if (i % 5'000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));  // they fall asleep
    threads.run([&](std::size_t k) { sums[k] += i; });
    ASSERT_EQ(sums, std::vector<int>(threads.threads(), sums.front())) << i;
  }
  EXPECT_EQ(sums.front(), 20'000 * 20'001 / 2);
}

TEST_P(WorkerThreadsOf, MakeEachStartedCallOnce) {
  WorkerThreads threads(GetParam());
  for (std::size_t count = 0; count < 40; ++count) {
    std::vector<std::atomic<int>> calls(count);
    const auto job = [&](std::size_t i) { ++calls[i]; };
    threads.start(count, job);
    threads.finish();
    for (const std::atomic<int>& made : calls) ASSERT_EQ(made, 1) << count << " calls";
  }
}

TEST_P(WorkerThreadsOf, RunBetweenStartAndFinish) {
  WorkerThreads threads(GetParam());
  std::array<std::size_t, 16> squares{};
  std::vector<std::size_t> sums(threads.threads());
  for (std::size_t round = 1; round <= 2'000; ++round) {
    squares.fill(0);
    const auto job = [&](std::size_t i) { squares[i] = round * i * i; };
    threads.start(squares.size(), job);
    for (int i = 0; i < 5; ++i) threads.run([&](std::size_t k) { sums[k] += 1; });
    threads.finish();
    for (std::size_t i = 0; i < squares.size(); ++i) ASSERT_EQ(squares[i], round * i * i);
    ASSERT_EQ(sums, std::vector<std::size_t>(threads.threads(), 5 * round));
  }
}

TEST_P(WorkerThreadsOf, EndWithoutWork) {
  WorkerThreads threads(GetParam());
  threads.finish();
  threads.start(0, [](std::size_t) {});
  threads.finish();
}

INSTANTIATE_TEST_SUITE_P(OneToFive, WorkerThreadsOf, testing::Values(1, 2, 3, 5));

TEST(WorkerThreads, AStartedCallIsMadeBesideTheCallingThread) {
  WorkerThreads threads(2);
  std::atomic<bool> begun = false;
  std::atomic<bool> may_end = false;
  const auto job = [&](std::size_t) {
    begun = true;
    begun.notify_one();
    may_end.wait(false);
  };
  threads.start(1, job);
  begun.wait(false);                // would wait for ever if the call waited for finish()
  threads.run([](std::size_t) {});  // makes all of its calls itself
  may_end = true;
  may_end.notify_one();
  threads.finish();
}

}  // namespace
}  // namespace saccade
