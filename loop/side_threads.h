#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>
#include <vector>

namespace saccade::inline v0_1 {

/// Threads that make calls beside the calling thread and sleep between. Starting and finishing calls allocates nothing.
class SideThreads {
 public:
  /// `threads`: at least 1, besides the calling one.
  explicit SideThreads(std::size_t threads);
  ~SideThreads();
  SideThreads(const SideThreads&) = delete;
  SideThreads& operator=(const SideThreads&) = delete;

  /// Begins job(0) to job(count - 1), each once, and returns at once. `job` does not throw and lives until finish(),
  /// which must be called before the next start().
  template <class Job>
  void start(std::size_t count, const Job& job) {
    start(
        count, [](const void* what, std::size_t i) { (*static_cast<const Job*>(what))(i); }, &job);
  }
  /// Makes the calls that no thread has begun, and returns when all are done.
  void finish();

 private:
  using Call = void (*)(const void* job, std::size_t i);

  void start(std::size_t count, Call call, const void* job);
  void work();

  std::mutex mutex_;
  std::condition_variable begin_;
  std::condition_variable done_;
  Call call_ = nullptr;
  const void* job_ = nullptr;
  std::size_t next_ = 0;
  std::size_t count_ = 0;
  std::size_t running_ = 0;
  bool ends_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace saccade::inline v0_1
