#include "threads/worker_threads.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
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

TEST_P(WorkerThreadsOf, RunAnyNumberOfCallsOnceEach) {
  WorkerThreads threads(GetParam());
  for (std::size_t count = 0; count < 40; ++count) {
    std::vector<std::atomic<int>> calls(count);
    threads.run(count, [&](std::size_t i) { ++calls[i]; });
    for (const std::atomic<int>& made : calls) ASSERT_EQ(made, 1) << count << " calls";
  }
}

TEST_P(WorkerThreadsOf, MakeEachStartedCallOnce) {
  WorkerThreads threads(GetParam());
  for (std::size_t count = 0; count < 40; ++count) {
    std::vector<std::atomic<int>> calls(count);
    const auto job = [&](std::size_t i) { ++calls[i]; };
    WorkerThreads::Started(threads, count, job).finish();
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
    WorkerThreads::Started started(threads, squares.size(), job);
    for (int i = 0; i < 5; ++i) threads.run([&](std::size_t k) { sums[k] += 1; });
    started.finish();
    for (std::size_t i = 0; i < squares.size(); ++i) ASSERT_EQ(squares[i], round * i * i);
    ASSERT_EQ(sums, std::vector<std::size_t>(threads.threads(), 5 * round));
  }
}

TEST_P(WorkerThreadsOf, EndWithoutWork) {
  WorkerThreads threads(GetParam());
  const auto job = [](std::size_t) {};
  WorkerThreads::Started(threads, 0, job).finish();
}

TEST_P(WorkerThreadsOf, EndTheStartedCallsBeforeTheirJobWhereTheCallerThrows) {
  WorkerThreads threads(GetParam());
  std::atomic<int> calls = 0;
  std::atomic<int> after_end = 0;
  for (int round = 0; round < 200; ++round) {
    struct Job {
      std::atomic<int>& calls;
      std::atomic<int>& after_end;
      std::atomic<bool> alive = true;
      ~Job() { alive = false; }
      void operator()(std::size_t) const {
        std::this_thread::sleep_for(std::chrono::microseconds(20));
        after_end += alive ? 0 : 1;
        ++calls;
      }
    };
    try {
      const Job job{calls, after_end};
      const WorkerThreads::Started started(threads, 5, job);
      throw std::runtime_error("the caller's");
    } catch (const std::runtime_error&) {
    }
    ASSERT_EQ(calls, 5 * (round + 1));
  }
  EXPECT_EQ(after_end, 0);
}

TEST_P(WorkerThreadsOf, ThrowInTheCallerWhatTheFirstCallThrew) {
  WorkerThreads threads(GetParam());
  std::vector<std::atomic<int>> calls(9);
  const auto job = [&](std::size_t i) {
    ++calls[i];
    if (i % 2 == 1) throw std::runtime_error("call " + std::to_string(i));
  };
  const auto message_of = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing";
  };
  for (int round = 1; round <= 50; ++round) {
    EXPECT_EQ(message_of([&] { WorkerThreads::Started(threads, calls.size(), job).finish(); }), "call 1");
    for (const std::atomic<int>& made : calls) ASSERT_EQ(made, round) << "the others are made all the same";
  }
  const auto last = [&](std::size_t i) {
    if (i + 1 == threads.threads()) throw std::runtime_error("the last call's");
  };
  EXPECT_EQ(message_of([&] { threads.run(last); }), "the last call's");
  std::vector<int> sums(threads.threads());
  threads.run([&](std::size_t k) { sums[k] = 1; });
  EXPECT_EQ(sums, std::vector<int>(threads.threads(), 1)) << "they work on";
}

INSTANTIATE_TEST_SUITE_P(OneToFive, WorkerThreadsOf, testing::Values(1, 2, 3, 5));

TEST(WorkerThreads, InAForkedProcessTheCallingThreadMakesAllCallsAndTheEndWaitsForNone) {
  auto threads = std::make_unique<WorkerThreads>(3);
  threads->run([](std::size_t) {});
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::alarm(20);  // ends the process where it waits for threads that it does not have
    int calls = 0;
    threads->run([&](std::size_t) { ++calls; });
    threads.reset();
    ::_exit(calls);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 3);
}

TEST(WorkerThreads, AStartedCallIsMadeBesideTheCallingThread) {
  WorkerThreads threads(2);
  std::atomic<bool> begun = false;
  std::atomic<bool> may_end = false;
  const auto job = [&](std::size_t) {
    begun = true;
    begun.notify_one();
    may_end.wait(false);
  };
  WorkerThreads::Started started(threads, 1, job);
  begun.wait(false);                // would wait for ever if the call waited for finish()
  threads.run([](std::size_t) {});  // makes all of its calls itself
  may_end = true;
  may_end.notify_one();
  started.finish();
}

}  // namespace
}  // namespace saccade
