#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// The events that a page shows: all of up to `most`, then every second, every fourth ... in the order of the recording.
class KeptEvents {
 public:
  static constexpr std::size_t most = 4'000'000;

  explicit KeptEvents(std::size_t most_events = most) : most_(most_events) {}

  void add(const Event& event);
  /// Of one camera, sorted by time.
  [[nodiscard]] std::vector<Event> of(std::uint8_t camera) const;
  [[nodiscard]] std::size_t total() const { return total_; }
  [[nodiscard]] std::size_t kept() const { return events_.size(); }
  /// One of so many events is kept.
  [[nodiscard]] std::size_t every() const { return every_; }

 private:
  std::size_t most_;
  std::vector<Event> events_;
  std::size_t total_ = 0;
  std::size_t every_ = 1;
};

}  // namespace saccade
