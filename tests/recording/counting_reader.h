#pragma once

#include <functional>
#include <utility>

#include "recording/event_file.h"

namespace saccade {

/// Returns `count` events, each at the time of its own number, then calls `at_end` and returns none.
class CountingReader final : public EventReader {
 public:
  CountingReader(std::int64_t count, std::function<void()> at_end)
      : count_(count), at_end_(std::move(at_end)) {}
  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t more = 0;
    for (; more < max_events && next_ < count_; ++more, ++next_) {
      events.push_back({next_, static_cast<std::uint16_t>(next_ % 300), 7, next_ % 3 == 0,
                        static_cast<std::uint8_t>(next_ % 2)});
    }
    if (more == 0) at_end_();
    return more;
  }
  std::optional<ImageSize> image_size() const override { return ImageSize{300, 8}; }
  std::string format() const override { return "counted"; }

 private:
  std::int64_t count_;
  std::function<void()> at_end_;
  std::int64_t next_ = 0;
};

}  // namespace saccade
