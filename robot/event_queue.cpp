#include "robot/event_queue.h"

#include <algorithm>

#include "core/error.h"

namespace saccade {
namespace {

std::uint64_t rest_of(const Event& event) {
  return std::uint64_t{event.x} | std::uint64_t{event.y} << 16 | std::uint64_t{event.on ? 1U : 0U} << 32 |
         std::uint64_t{event.camera} << 40;
}

Event event_of(std::int64_t t_us, std::uint64_t rest) {
  return {t_us, static_cast<std::uint16_t>(rest), static_cast<std::uint16_t>(rest >> 16),
          ((rest >> 32) & 1) != 0, static_cast<std::uint8_t>(rest >> 40)};
}

}  // namespace

EventQueue::EventQueue(std::size_t capacity)
    : capacity_(static_cast<std::int64_t>(capacity)), ring_(capacity + 1) {
  SACCADE_CHECK(capacity >= 1);
}

void EventQueue::push(std::span<const Event> events) {
  std::int64_t at = pushed_.load(std::memory_order_relaxed);
  const auto slots = static_cast<std::int64_t>(ring_.size());
  for (const Event& event : events) {
    // The slot of the event `slots` before this one: nobody may trust it from now on.
    begun_.store(at + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    Slot& slot = ring_[static_cast<std::size_t>(at % slots)];
    slot.t_us.store(event.t_us, std::memory_order_relaxed);
    slot.rest.store(rest_of(event), std::memory_order_relaxed);
    pushed_.store(++at, std::memory_order_release);
  }
}

void EventQueue::pop_until(std::int64_t t_us, std::vector<Event>& events) {
  const auto slots = static_cast<std::int64_t>(ring_.size());
  const std::int64_t end = pushed_.load(std::memory_order_acquire);
  const std::int64_t first = read_.load(std::memory_order_relaxed);
  std::int64_t at = std::max(first, end - capacity_);
  std::int64_t dropped = at - first;
  while (at < end) {
    const Slot& slot = ring_[static_cast<std::size_t>(at % slots)];
    const std::int64_t stamp_us = slot.t_us.load(std::memory_order_relaxed);
    const std::uint64_t rest = slot.rest.load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    const std::int64_t oldest = begun_.load(std::memory_order_relaxed) - slots;
    if (at < oldest) {  // overwritten while it was read
      const std::int64_t next = std::min(oldest, end);
      dropped += next - at;
      at = next;
      continue;
    }
    if (stamp_us > t_us) break;
    events.push_back(event_of(stamp_us, rest));
    ++at;
  }
  read_.store(at, std::memory_order_release);
  if (dropped > 0) dropped_.fetch_add(dropped, std::memory_order_relaxed);
}

std::int64_t EventQueue::size() const {
  return std::clamp<std::int64_t>(pushed_.load() - read_.load(), 0, capacity_);
}

std::int64_t EventQueue::dropped() const {
  // Those that are too old and that the reading thread has not come to yet count too.
  return dropped_.load() + std::max<std::int64_t>(0, pushed_.load() - read_.load() - capacity_);
}

}  // namespace saccade
