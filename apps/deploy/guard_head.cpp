#include "apps/deploy/guard_head.h"

#include <utility>

#include "apps/deploy/shared_memory.h"
#include "core/error.h"

namespace saccade {

GuardHead::GuardHead(Open open, std::chrono::milliseconds patience, std::chrono::milliseconds retry)
    : open_(std::move(open)),
      patience_(patience),
      retry_(retry),
      head_(open_()),
      heard_ns_(machine_ns()),
      thread_([this] { renew(); }) {}

GuardHead::~GuardHead() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool GuardHead::is_connected() {
  {
    const std::lock_guard lock(mutex_);
    if (renewing_) return false;
  }
  const std::int64_t now_ns = machine_ns();
  if (head_->is_connected()) {
    heard_ns_ = now_ns;
    return true;
  }
  if (now_ns - heard_ns_ < std::chrono::nanoseconds(patience_).count()) return false;
  {
    const std::lock_guard lock(mutex_);
    renewing_ = true;
  }
  changed_.notify_all();
  return false;
}

bool GuardHead::stop() {
  {
    const std::lock_guard lock(mutex_);
    if (renewing_) return false;
  }
  return head_->stop();
}

std::string GuardHead::problem() {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void GuardHead::renew() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return over_ || renewing_; });
    if (over_) return;
    lock.unlock();
    head_.reset();
    std::unique_ptr<HeadStopper> next;
    std::string problem;
    try {
      next = open_();
      if (!next->is_connected()) problem = "the head does not answer";
    } catch (const std::exception& error) {
      problem = error.what();
    }
    if (!problem.empty()) next.reset();
    lock.lock();
    problem_ = problem;
    if (next == nullptr) {
      changed_.wait_for(lock, retry_, [this] { return over_; });
      continue;
    }
    head_ = std::move(next);
    heard_ns_ = machine_ns();
    renewing_ = false;
  }
}

}  // namespace saccade
