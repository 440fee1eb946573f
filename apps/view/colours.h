#pragma once

#include <imgui.h>

#include <string>

#include "evaluation/report/palette.h"

namespace saccade {

/// Colours of the window. Those of detectors, truth, events and gaze are the palette's, as in reports and figures.
namespace colours {

[[nodiscard]] constexpr ImU32 of(const Colour& colour) {
  return IM_COL32(colour.red, colour.green, colour.blue, 255);
}

inline constexpr ImU32 on = of(on_colour);
inline constexpr ImU32 off = of(off_colour);
inline constexpr ImU32 truth = of(truth_colour);
inline constexpr ImU32 gaze = of(gaze_colour);  ///< optical axis and gaze error
inline constexpr ImU32 target = of(gaze_target_colour);
[[nodiscard]] inline ImU32 detector(const std::string& name) { return of(detector_colour(name)); }

inline constexpr ImU32 white = IM_COL32(255, 255, 255, 255);
inline constexpr ImU32 rim = IM_COL32(0, 0, 0, 190);  ///< around marks, so that they show on any image
inline constexpr ImU32 dim = IM_COL32(150, 150, 156, 255);
inline constexpr ImU32 field_of_view = IM_COL32(110, 190, 250, 255);
inline constexpr ImU32 problem = IM_COL32(255, 128, 107, 255);  ///< of what was rejected or has ended
inline constexpr ImU32 threshold = IM_COL32(240, 70, 60, 255);
inline constexpr ImU32 sheet = IM_COL32(22, 22, 24, 255);  ///< of plots and timeline
inline constexpr ImU32 gap = IM_COL32(17, 17, 19, 255);    ///< between panels

}  // namespace colours

}  // namespace saccade
