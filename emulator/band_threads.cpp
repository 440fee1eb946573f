#include "emulator/band_threads.h"

#include "core/error.h"

namespace saccade::inline v0_1 {
namespace {

constexpr std::uint64_t band_mask = 0xffffffffU;
constexpr int looks_per_yield = 64;

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Waits actively; other threads get the processor now and then.
template <class Condition>
void spin_until(const Condition& is_met) {
  for (int looks = 1; !is_met(); ++looks) {
    if (looks % looks_per_yield == 0) {
      std::this_thread::yield();
    } else {
      pause_briefly();
    }
  }
}

}  // namespace

BandThreads::BandThreads(std::size_t bands) : bands_(bands), next_(bands) {
  SACCADE_CHECK(bands > 0);
  for (std::size_t i = 1; i < bands; ++i) threads_.emplace_back([this] { work(); });
}

BandThreads::~BandThreads() {
  ends_.store(true);
  signal_.fetch_add(1);
  signal_.notify_all();
}

void BandThreads::wake() {
  if (threads_.empty()) return;
  awake_.store(true);
  signal_.fetch_add(1);
  signal_.notify_all();
}

void BandThreads::run(Call call, const void* job) {
  if (threads_.empty()) return call(job, 0);
  call_ = call;
  job_ = job;
  running_.store(bands_);
  next_.store((next_.load() | band_mask) + 1);  // the next job, from band 0 on
  signal_.fetch_add(1);
  signal_.notify_all();
  while (run_next()) {
  }
  spin_until([this] { return running_.load() == 0; });
}

/// Runs the next band of the job. Returns false if all are begun.
bool BandThreads::run_next() {
  std::uint64_t next = next_.load();
  do {
    if ((next & band_mask) >= bands_) return false;
  } while (!next_.compare_exchange_weak(next, next + 1));
  call_(job_, static_cast<std::size_t>(next & band_mask));
  running_.fetch_sub(1);
  return true;
}

void BandThreads::work() {
  const auto has_band = [this] { return (next_.load() & band_mask) < bands_; };
  for (;;) {
    const std::uint32_t seen = signal_.load();
    if (ends_.load()) return;
    if (run_next()) continue;
    if (awake_.load()) {
      spin_until([&] { return has_band() || !awake_.load() || ends_.load(); });
    } else {
      signal_.wait(seen);
    }
  }
}

}  // namespace saccade::inline v0_1
