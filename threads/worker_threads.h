#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace saccade::inline v0_1 {

/// Threads that work beside the calling one, on calls of some microseconds to milliseconds. A thread without work waits
/// actively for a fifth of a millisecond, because waking one takes longer than many calls, and sleeps then. The calls allocate
/// nothing and do not throw. One thread at a time uses it.
class WorkerThreads {
 public:
  /// `threads`: the calling one included, at least 1.
  explicit WorkerThreads(std::size_t threads);
  ~WorkerThreads();
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  [[nodiscard]] std::size_t threads() const { return threads_.size() + 1; }

  /// Calls job(0) to job(threads() - 1), each once, in any of the threads, and returns when all are done. The caller makes the
  /// calls that no thread begins.
  template <class Job>
  void run(const Job& job) {
    if (threads_.empty()) return job(0);
    begin(shared_, threads(), call_of<Job>, &job);
    end(shared_);
  }

  /// Begins job(0) to job(count - 1), each once, in the other threads, and returns at once. `job` lives until finish(), which
  /// must be called before the next start(). run() may be called between; its calls come first.
  template <class Job>
  void start(std::size_t count, const Job& job) {
    begin(started_, count, call_of<Job>, &job);
  }
  /// Makes the calls of start() that no thread has begun, and returns when all are done.
  void finish() { end(started_); }

 private:
  using Call = void (*)(const void* job, std::size_t i);
  struct Calls {
    Call call = nullptr;
    const void* job = nullptr;
    std::atomic<std::uint64_t> todo = 0;  ///< calls to begin; in the upper 32 bits the number of the job
    std::atomic<std::uint32_t> left = 0;  ///< calls that are not done
  };

  template <class Job>
  static void call_of(const void* job, std::size_t i) {
    (*static_cast<const Job*>(job))(i);
  }
  void begin(Calls& calls, std::size_t count, Call call, const void* job);
  static void end(Calls& calls);
  static bool make_next(Calls& calls);
  void work();

  Calls shared_;                           // of run()
  Calls started_;                          // of start()
  std::atomic<std::uint32_t> signal_ = 0;  // changes when there is work, or none will come
  std::atomic<bool> ends_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace saccade::inline v0_1
