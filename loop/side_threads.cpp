#include "loop/side_threads.h"

#include "core/error.h"

namespace saccade::inline v0_1 {

SideThreads::SideThreads(std::size_t threads) {
  SACCADE_CHECK(threads > 0);
  for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

SideThreads::~SideThreads() {
  finish();
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  begin_.notify_all();
}

void SideThreads::start(std::size_t count, Call call, const void* job) {
  {
    const std::lock_guard lock(mutex_);
    SACCADE_CHECK(next_ == count_ && running_ == 0);
    call_ = call;
    job_ = job;
    next_ = 0;
    count_ = count;
  }
  begin_.notify_all();
}

void SideThreads::finish() {
  std::unique_lock lock(mutex_);
  while (next_ < count_) {
    const std::size_t i = next_++;
    lock.unlock();
    call_(job_, i);
    lock.lock();
  }
  done_.wait(lock, [this] { return running_ == 0; });
}

void SideThreads::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    begin_.wait(lock, [this] { return ends_ || next_ < count_; });
    if (ends_) return;
    const std::size_t i = next_++;
    ++running_;
    lock.unlock();
    call_(job_, i);
    lock.lock();
    if (--running_ == 0) done_.notify_one();
  }
}

}  // namespace saccade::inline v0_1
