#include "threads/worker_threads.h"

#include <pthread.h>

#include <chrono>
#include <utility>

#include "core/error.h"

namespace saccade {
namespace {

constexpr std::uint64_t count_mask = 0xffffffffU;
constexpr int looks_per_yield = 64;
constexpr std::chrono::microseconds longest_active_wait{200};

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Waits actively until `value` is not `old`, for a limited time; other threads get the processor now and then. Then sleeps.
template <class T>
void wait_while(const std::atomic<T>& value, T old) {
  const auto begin = std::chrono::steady_clock::now();
  for (int looks = 1; value.load() == old; ++looks) {
    if (looks % looks_per_yield != 0) {
      pause_briefly();
      continue;
    }
    if (std::chrono::steady_clock::now() - begin > longest_active_wait) return value.wait(old);
    std::this_thread::yield();
  }
}

/// How often the process was forked on its way from the first one. Global: fork() has no other way in.
std::atomic<int> forks = 0;

void count_forks() {
  static const int failure = ::pthread_atfork(nullptr, nullptr, [] { forks.fetch_add(1); });
  SACCADE_CHECK(failure == 0);
}

}  // namespace

WorkerThreads::WorkerThreads(std::size_t threads) {
  SACCADE_CHECK(threads > 0);
  count_forks();
  forks_ = forks.load();
  for (std::size_t i = 1; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

WorkerThreads::~WorkerThreads() {
  if (forks.load() != forks_) {
    // A forked process has the calling thread alone: there is nothing to wait for.
    for (std::jthread& thread : threads_) thread.detach();
    return;
  }
  ends_.store(true);
  signal_.fetch_add(1);
  signal_.notify_all();
}

void WorkerThreads::begin(Calls& calls, std::size_t count, Call call, const void* job) {
  SACCADE_CHECK(calls.left.load() == 0 && count <= count_mask);
  calls.call = call;
  calls.job = job;
  calls.failure = nullptr;
  calls.left.store(static_cast<std::uint32_t>(count));
  calls.todo.store((calls.todo.load() | count_mask) + 1 + count);
  signal_.fetch_add(1);
  signal_.notify_all();
}

void WorkerThreads::end(Calls& calls) {
  while (make_next(calls)) {
  }
  for (std::uint32_t left = calls.left.load(); left > 0; left = calls.left.load())
    wait_while(calls.left, left);
}

/// After end().
void WorkerThreads::rethrow(Calls& calls) {
  if (calls.failure) std::rethrow_exception(std::exchange(calls.failure, nullptr));
}

/// Makes the next call of the job. Returns false if all are begun.
bool WorkerThreads::make_next(Calls& calls) {
  std::uint64_t todo = calls.todo.load();
  do {
    if ((todo & count_mask) == 0) return false;
  } while (!calls.todo.compare_exchange_weak(todo, todo - 1));
  const std::size_t i = static_cast<std::size_t>(todo & count_mask) - 1;
  try {
    calls.call(calls.job, i);
  } catch (...) {
    const std::lock_guard lock(calls.failing);
    if (!calls.failure || i < calls.failed_call) {
      calls.failure = std::current_exception();
      calls.failed_call = i;
    }
  }
  calls.left.fetch_sub(1);
  calls.left.notify_one();
  return true;
}

void WorkerThreads::work() {
  for (;;) {
    const std::uint32_t seen = signal_.load();
    if (ends_.load()) return;
    if (make_next(shared_) || make_next(started_)) continue;
    wait_while(signal_, seen);
  }
}

}  // namespace saccade
