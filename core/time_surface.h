#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/event.h"

namespace saccade {

/// The surface of active events: the time of the newest ON and of the newest OFF event of every pixel. Does not allocate
/// after construction.
class TimeSurface {
 public:
  /// Of a pixel and polarity without an event.
  static constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();

  explicit TimeSurface(ImageSize size)
      : size_(size), pixels_(static_cast<std::size_t>(size.pixels())), newest_us_(2 * pixels_, never_us) {}

  /// The event lies inside the image; time stamps do not go back.
  void add(const Event& event) { newest_us_[index(event)] = event.t_us; }
  /// Loads what an event inside the image changes into the cache, some events before it is added.
  void prefetch(const Event& event) const { __builtin_prefetch(&newest_us_[index(event)], 1); }

  [[nodiscard]] ImageSize size() const { return size_; }
  /// The times of one polarity, us: rows of pixels from top to bottom.
  [[nodiscard]] std::span<const std::int64_t> newest_us(bool on) const {
    return std::span(newest_us_).subspan(on ? 0 : pixels_, pixels_);
  }

 private:
  [[nodiscard]] std::size_t index(const Event& e) const {
    return (e.on ? 0U : pixels_) + static_cast<std::size_t>(e.y * size_.width + e.x);
  }

  ImageSize size_;
  std::size_t pixels_;
  std::vector<std::int64_t> newest_us_;  // ON, then OFF
};

}  // namespace saccade
