#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace saccade {

/// The colours of events, truth, detectors and gaze, the same in the window, in reports and in figures.
///
/// Most are those of M. Okabe and K. Ito, "Color Universal Design" (2008), which people with any kind of colour vision
/// can tell apart, or from P. Tol's "muted" scheme. All are visible on white and on black.

struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  bool operator==(const Colour&) const = default;
};

inline constexpr Colour on_colour{0xe6, 0x9f, 0x00};           ///< ON events: orange
inline constexpr Colour off_colour{0x00, 0x72, 0xb2};          ///< OFF events: blue
inline constexpr Colour truth_colour{0x00, 0x9e, 0x73};        ///< the true ball: bluish green
inline constexpr Colour gaze_colour{0x7b, 0x6c, 0xd9};         ///< where the gaze is: violet
inline constexpr Colour gaze_target_colour{0xaa, 0x44, 0x99};  ///< where the gaze is to go: purple

/// The colour of a detector: it depends on the name alone, so that a detector looks the same in every run, sweep, figure and
/// window. Those of this project have one each; of others the name's hash chooses one that is unlike them.
[[nodiscard]] Colour detector_colour(std::string_view name);

/// "#rrggbb"
[[nodiscard]] std::string hex(Colour colour);

}  // namespace saccade
