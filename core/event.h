#pragma once

#include <cstdint>
#include <type_traits>

namespace saccade {

/// One brightness change at one pixel of an event camera (paper, section II-A).
///
/// Time is absolute in the stream's own clock. Pixel (0, 0) is the centre of the top-left pixel, x to
/// the right, y down. Polarity is ON = brighter = true; readers of formats that invert it
/// convert it.
struct Event {
  std::int64_t t_us = 0;
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  bool on = false;
  std::uint8_t camera = 0;  ///< 0 left, 1 right

  friend bool operator==(const Event&, const Event&) = default;
};
static_assert(sizeof(Event) == 16 && std::is_trivially_copyable_v<Event>);

/// Width and height of an image, pixels.
struct ImageSize {
  int width = 0;
  int height = 0;

  [[nodiscard]] bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  [[nodiscard]] int pixels() const { return width * height; }
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

}  // namespace saccade
