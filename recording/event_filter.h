#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/event.h"

namespace saccade {

/// A number for each pixel of each camera, for images of any size.
template <class Value>
class PixelTable {
 public:
  explicit PixelTable(Value initial) : initial_(initial) {}

  [[nodiscard]] Value& at(int camera, int x, int y) {
    Plane& plane = planes_.at(static_cast<std::size_t>(camera));
    if (y >= static_cast<int>(plane.size())) plane.resize(static_cast<std::size_t>(y) + 1);
    std::vector<Value>& row = plane[static_cast<std::size_t>(y)];
    if (x >= static_cast<int>(row.size())) row.resize(static_cast<std::size_t>(x) + 1, initial_);
    return row[static_cast<std::size_t>(x)];
  }
  /// The initial value outside of what at() has reached.
  [[nodiscard]] Value get(int camera, int x, int y) const {
    const Plane& plane = planes_.at(static_cast<std::size_t>(camera));
    if (x < 0 || y < 0 || y >= static_cast<int>(plane.size())) return initial_;
    const std::vector<Value>& row = plane[static_cast<std::size_t>(y)];
    return x < static_cast<int>(row.size()) ? row[static_cast<std::size_t>(x)] : initial_;
  }
  /// Calls `use(camera, x, y, value)` with what at() has reached.
  template <class Use>
  void for_each(const Use& use) const {
    for (std::size_t camera = 0; camera < planes_.size(); ++camera) {
      for (std::size_t y = 0; y < planes_[camera].size(); ++y) {
        for (std::size_t x = 0; x < planes_[camera][y].size(); ++x)
          use(static_cast<int>(camera), static_cast<int>(x), static_cast<int>(y), planes_[camera][y][x]);
      }
    }
  }

 private:
  using Plane = std::vector<std::vector<Value>>;
  Value initial_;
  std::array<Plane, 256> planes_;
};

/// A pixel is hot that has at least `least` events, and more than `factor` times the mean of its eight neighbours.
class HotPixels {
 public:
  static constexpr std::int64_t least = 100;
  static constexpr std::int64_t factor = 10;

  void add(const Event& event) { ++counts_.at(event.camera, event.x, event.y); }
  [[nodiscard]] bool is_hot(int camera, int x, int y) const {
    const std::int64_t count = counts_.get(camera, x, y);
    if (count < least) return false;
    std::int64_t around = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) around += counts_.get(camera, x + dx, y + dy);
    }
    return 8 * count > factor * (around - count);
  }
  [[nodiscard]] std::int64_t number() const {
    std::int64_t hot = 0;
    counts_.for_each([&](int camera, int x, int y, std::int64_t) { hot += is_hot(camera, x, y) ? 1 : 0; });
    return hot;
  }

 private:
  PixelTable<std::int64_t> counts_{0};
};

/// Background activity: an event without one of its eight neighbours in the `window_us` before it.
class BackgroundActivity {
 public:
  static constexpr std::int64_t window_us = 10'000;

  [[nodiscard]] bool is_background(const Event& event) {
    bool alone = true;
    for (int dy = -1; dy <= 1 && alone; ++dy) {
      for (int dx = -1; dx <= 1 && alone; ++dx) {
        if (dx == 0 && dy == 0) continue;
        const std::int64_t last_us = newest_us_.get(event.camera, event.x + dx, event.y + dy);
        alone = last_us == never_us || event.t_us - last_us > window_us || event.t_us < last_us;
      }
    }
    newest_us_.at(event.camera, event.x, event.y) = event.t_us;
    return alone;
  }

 private:
  static constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();
  PixelTable<std::int64_t> newest_us_{never_us};
};

}  // namespace saccade
