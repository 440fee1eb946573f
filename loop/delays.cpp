#include "loop/delays.h"

#include <algorithm>

#include "core/error.h"

namespace saccade {

TransportDelay::TransportDelay(std::int64_t delay_us, std::size_t reserved_events) : delay_us_(delay_us) {
  SACCADE_CHECK(delay_us >= 0);
  events_.reserve(reserved_events);
}

std::span<const Event> TransportDelay::pass(std::span<const Event> events, std::int64_t t_us) {
  events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(passed_));
  events_.insert(events_.end(), events.begin(), events.end());
  const auto end = std::ranges::upper_bound(events_, t_us - delay_us_, {}, &Event::t_us);
  passed_ = static_cast<std::size_t>(end - events_.begin());
  return {events_.data(), passed_};
}

CommandDelay::CommandDelay() : ring_(capacity) {}

void CommandDelay::push(const HeadCommand& reference_rad, std::int64_t ready_us) {
  SACCADE_CHECK(count_ < capacity);
  const std::size_t last = (first_ + count_ + capacity - 1) % capacity;
  if (count_ > 0) ready_us = std::max(ready_us, ring_[last].ready_us);
  ring_[(first_ + count_++) % capacity] = {reference_rad, ready_us};
}

std::optional<HeadCommand> CommandDelay::pop(std::int64_t t_us) {
  std::optional<HeadCommand> newest;
  for (; count_ > 0 && ring_[first_].ready_us <= t_us; --count_) {
    newest = ring_[first_].reference_rad;
    first_ = (first_ + 1) % capacity;
  }
  return newest;
}

}  // namespace saccade
