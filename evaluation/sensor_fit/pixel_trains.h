#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// An event of a pixel.
struct TrainEvent {
  std::int64_t t_us = 0;
  bool on = false;
};

/// The events of some pixels, each pixel's one after the other in the order in which they were added.
class PixelTrains {
 public:
  explicit PixelTrains(std::size_t pixels) : begin_(pixels + 1, 0) {}

  void add(std::size_t pixel, TrainEvent event) {
    added_.push_back({static_cast<std::uint32_t>(pixel), event});
  }
  /// Sorts what was added by pixel; no more is added after it.
  void finish();
  /// The same without the pixels for which `dropped` is not 0.
  [[nodiscard]] PixelTrains without(std::span<const std::uint8_t> dropped) const;
  /// The same with every other pixel: the first, third, ... or the second, fourth, ... of them.
  [[nodiscard]] PixelTrains half(bool second) const;

  [[nodiscard]] std::size_t pixels() const { return begin_.size() - 1; }
  [[nodiscard]] std::size_t events() const { return events_.size(); }
  [[nodiscard]] std::span<const TrainEvent> of(std::size_t pixel) const {
    return std::span(events_).subspan(begin_[pixel], begin_[pixel + 1] - begin_[pixel]);
  }

 private:
  struct Added {
    std::uint32_t pixel;
    TrainEvent event;
  };
  std::vector<std::size_t> begin_;
  std::vector<TrainEvent> events_;
  std::vector<Added> added_;
};

}  // namespace saccade
