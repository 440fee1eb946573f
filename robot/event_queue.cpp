#include "robot/event_queue.h"

#include <algorithm>

#include "core/error.h"

namespace saccade {

EventQueue::EventQueue(std::size_t capacity) : ring_(capacity) { SACCADE_CHECK(capacity >= 1); }

void EventQueue::push(std::span<const Event> events) {
  const std::lock_guard lock(mutex_);
  if (events.size() > ring_.size()) {
    dropped_ += static_cast<std::int64_t>(events.size() - ring_.size());
    events = events.last(ring_.size());
  }
  const std::size_t room = ring_.size() - count_;
  if (events.size() > room) {
    const std::size_t excess = events.size() - room;
    first_ = (first_ + excess) % ring_.size();
    count_ -= excess;
    dropped_ += static_cast<std::int64_t>(excess);
  }
  for (const Event& event : events) ring_[(first_ + count_++) % ring_.size()] = event;
}

void EventQueue::pop_until(std::int64_t t_us, std::vector<Event>& events) {
  const std::lock_guard lock(mutex_);
  while (count_ > 0 && ring_[first_].t_us <= t_us) {
    events.push_back(ring_[first_]);
    first_ = (first_ + 1) % ring_.size();
    --count_;
  }
}

std::int64_t EventQueue::size() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::int64_t>(count_);
}

std::int64_t EventQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace saccade
