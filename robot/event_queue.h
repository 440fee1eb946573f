#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// A queue of events of fixed capacity between a receiving and a reading thread. If it is full, the oldest events are
/// dropped, because gaze control needs the newest ones. Does not allocate after construction.
class EventQueue {
 public:
  /// capacity >= 1, events.
  explicit EventQueue(std::size_t capacity);

  /// Adds events, sorted by time.
  void push(std::span<const Event> events);
  /// Appends the events with time stamps <= t_us.
  void pop_until(std::int64_t t_us, std::vector<Event>& events);
  [[nodiscard]] std::int64_t size() const;
  /// Events dropped so far.
  [[nodiscard]] std::int64_t dropped() const;

 private:
  mutable std::mutex mutex_;
  std::vector<Event> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace saccade
