#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace saccade {

/// Threads that work beside the calling one, on calls of some microseconds to milliseconds. A thread without work waits
/// actively for a fifth of a millisecond, because waking one takes longer than many calls, and sleeps then. The calls allocate
/// nothing. Where some throw, the others are made all the same, and the caller gets the exception of the call with the lowest
/// number. One thread at a time uses it. In a process that was forked from the one that made it, the calling thread makes
/// all calls.
class WorkerThreads {
 public:
  /// `threads`: the calling one included, at least 1.
  explicit WorkerThreads(std::size_t threads);
  ~WorkerThreads();
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  [[nodiscard]] std::size_t threads() const { return threads_.size() + 1; }

  /// Calls job(0) to job(count - 1), each once, in any of the threads, and returns when all are done. The caller makes the
  /// calls that no thread begins.
  template <class Job>
  void run(std::size_t count, const Job& job) {
    if (count == 1) return job(0);
    begin(shared_, count, call_of<Job>, &job);
    end(shared_);
    rethrow(shared_);
  }
  /// run(threads(), job)
  template <class Job>
  void run(const Job& job) {
    run(threads(), job);
  }

  /// Calls that the other threads make: job(0) to job(count - 1), each once. One object at a time; run() may be called while it
  /// exists, its calls come first.
  class Started {
   public:
    /// Begins the calls and returns at once. `job` and `threads` outlive this object.
    template <class Job>
    Started(WorkerThreads& threads, std::size_t count, const Job& job) : threads_(threads) {
      threads.begin(threads.started_, count, call_of<Job>, &job);
    }
    /// No call is under way any more, also where an exception has left out finish().
    ~Started() { end(threads_.started_); }
    Started(const Started&) = delete;
    Started& operator=(const Started&) = delete;

    /// Makes the calls that no thread has begun, and returns when all are done.
    void finish() {
      end(threads_.started_);
      rethrow(threads_.started_);
    }

   private:
    WorkerThreads& threads_;
  };

 private:
  using Call = void (*)(const void* job, std::size_t i);
  struct Calls {
    Call call = nullptr;
    const void* job = nullptr;
    std::atomic<std::uint64_t> todo = 0;  ///< calls to begin; in the upper 32 bits the number of the job
    std::atomic<std::uint32_t> left = 0;  ///< calls that are not done
    std::mutex failing;
    std::exception_ptr failure;  ///< of the call failed_call
    std::size_t failed_call = 0;
  };

  template <class Job>
  static void call_of(const void* job, std::size_t i) {
    (*static_cast<const Job*>(job))(i);
  }
  void begin(Calls& calls, std::size_t count, Call call, const void* job);
  static void end(Calls& calls);
  static void rethrow(Calls& calls);
  static bool make_next(Calls& calls);
  void work();

  Calls shared_;                           // of run()
  Calls started_;                          // of Started
  std::atomic<std::uint32_t> signal_ = 0;  // changes when there is work, or none will come
  std::atomic<bool> ends_ = false;
  int forks_;  // of this process's line when the threads began
  std::vector<std::jthread> threads_;
};

}  // namespace saccade
