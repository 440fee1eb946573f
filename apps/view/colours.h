#pragma once

#include <imgui.h>

#include <string>

#include "apps/view/images.h"
#include "apps/view/view_settings.h"

namespace saccade {

/// Colours of the window on its dark ground. Those of detectors, truth, ON and OFF are the palette's.
namespace colours {

inline constexpr ImU32 white = IM_COL32(255, 255, 255, 255);
inline constexpr ImU32 rim = IM_COL32(0, 0, 0, 190);  ///< around marks, so that they show on any image
inline constexpr ImU32 dim = IM_COL32(150, 150, 156, 255);
inline constexpr ImU32 gaze = IM_COL32(250, 220, 60, 255);  ///< optical axis and gaze error
inline constexpr ImU32 field_of_view = IM_COL32(110, 190, 250, 255);
inline constexpr ImU32 threshold = IM_COL32(240, 70, 60, 255);
inline constexpr ImU32 sheet = IM_COL32(22, 22, 24, 255);  ///< of plots and timeline
inline constexpr ImU32 gap = IM_COL32(17, 17, 19, 255);    ///< between panels

/// "#rrggbb".
[[nodiscard]] ImU32 of_hex(const std::string& hex);
/// The report's colour of a detector, lighter.
[[nodiscard]] ImU32 detector(const ViewSettings& settings, const std::string& name);
inline constexpr ImU32 truth = white;
inline constexpr ImU32 target = IM_COL32(0xe6, 0x9f, 0x00, 255);
[[nodiscard]] inline ImU32 of_rgb(const Rgb& rgb) { return IM_COL32(rgb[0], rgb[1], rgb[2], 255); }

}  // namespace colours

}  // namespace saccade
