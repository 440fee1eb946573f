#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "recording/event_file.h"

namespace saccade {

/// Events in memory, read like an event file. The memory outlives the reader.
class MemoryReader final : public EventReader {
 public:
  MemoryReader(std::span<const Event> events, ImageSize size) : events_(events), size_(size) {}
  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    const auto block = events_.first(std::min(max_events, events_.size()));
    events.insert(events.end(), block.begin(), block.end());
    events_ = events_.subspan(block.size());
    return block.size();
  }
  [[nodiscard]] std::optional<ImageSize> image_size() const override { return size_; }
  [[nodiscard]] std::string format() const override { return "memory"; }

 private:
  std::span<const Event> events_;
  ImageSize size_;
};

}  // namespace saccade
