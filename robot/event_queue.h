#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// A queue of events of fixed capacity from one receiving thread to one reading thread. If it is full, the oldest events
/// are dropped, because gaze control needs the newest ones. Neither side locks, waits or allocates: the receiving thread
/// overwrites the oldest events, and the reading thread skips what was overwritten.
class EventQueue {
 public:
  /// capacity >= 1, events.
  explicit EventQueue(std::size_t capacity);

  /// Receiving thread: adds events, sorted by time.
  void push(std::span<const Event> events);
  /// Reading thread: appends the events with time stamps <= t_us.
  void pop_until(std::int64_t t_us, std::vector<Event>& events);
  /// Events that pop_until can still return. Any thread.
  [[nodiscard]] std::int64_t size() const;
  /// Events dropped so far. Any thread.
  [[nodiscard]] std::int64_t dropped() const;

 private:
  struct Slot {
    std::atomic<std::int64_t> t_us;
    std::atomic<std::uint64_t> rest;
  };

  std::int64_t capacity_;
  std::vector<Slot> ring_;                           // one more than the capacity: the event that is written
  alignas(64) std::atomic<std::int64_t> begun_ = 0;  // events whose slots may be overwritten already
  std::atomic<std::int64_t> pushed_ = 0;             // events that are whole
  alignas(64) std::atomic<std::int64_t> read_ = 0;   // events read or skipped
  std::atomic<std::int64_t> dropped_ = 0;
};

}  // namespace saccade
