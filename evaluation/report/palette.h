#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saccade::inline v0_1 {

/// The colours of events, truth, detectors and gaze, the same in the window, in reports and in figures.
///
/// Most are those of M. Okabe and K. Ito, "Color Universal Design" (2008), which people with any kind of colour vision
/// can tell apart; the others are from P. Tol's "muted" scheme. All are visible on white and on black.

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

/// The colours of detectors, by name: fixed for those of this project, for others chosen by a hash of the name among
/// the colours that remain. Names of one list have different colours as long as there are colours left; the result
/// depends on nothing but the list.
[[nodiscard]] std::vector<Colour> detector_colours(std::span<const std::string> names);
/// The colour of a detector that stands alone.
[[nodiscard]] Colour detector_colour(const std::string& name);

/// "#rrggbb"
[[nodiscard]] std::string hex(Colour colour);

}  // namespace saccade::inline v0_1
