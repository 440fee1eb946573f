#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace saccade::inline v0_1 {

/// Threads that share the bands of an image with the calling thread: jobs of some ten microseconds each. Running jobs
/// allocates nothing. One thread at a time uses it.
class BandThreads {
 public:
  /// `bands`: number of bands, at least 1; one thread less is started.
  explicit BandThreads(std::size_t bands);
  ~BandThreads();
  BandThreads(const BandThreads&) = delete;
  BandThreads& operator=(const BandThreads&) = delete;

  [[nodiscard]] std::size_t bands() const { return bands_; }

  /// From wake() until rest() the threads wait for jobs without sleeping, because waking a thread takes longer than a job.
  void wake();
  void rest() { awake_.store(false, std::memory_order_relaxed); }

  /// Calls job(0) to job(bands() - 1), each once, in any of the threads, and returns when all are done. The caller makes the
  /// calls that no thread begins. `job` does not throw.
  template <class Job>
  void run(const Job& job) {
    run([](const void* what, std::size_t band) { (*static_cast<const Job*>(what))(band); }, &job);
  }

 private:
  using Call = void (*)(const void* job, std::size_t band);

  void run(Call call, const void* job);
  bool run_next();
  void work();

  std::size_t bands_;
  Call call_ = nullptr;
  const void* job_ = nullptr;
  // The number of the job and the next band of it, in the upper and lower 32 bits.
  std::atomic<std::uint64_t> next_;
  std::atomic<std::size_t> running_ = 0;   ///< bands of the job that are not done
  std::atomic<std::uint32_t> signal_ = 0;  ///< changes when a sleeping thread has to look again
  std::atomic<bool> awake_ = false;
  std::atomic<bool> ends_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace saccade::inline v0_1
