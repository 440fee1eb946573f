#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/event.h"

namespace saccade {

inline constexpr ImageSize aedat_dvs128_size{128, 128};
inline constexpr ImageSize aedat_dvs640_size{640, 480};
/// Of the DAVIS family, the smallest first.
inline constexpr std::array<ImageSize, 3> aedat_davis_sizes{{{240, 180}, {346, 260}, {640, 480}}};

/// Layout and image size of a sensor, from its name in the headers of iniVation's programs.
struct AedatChip {
  std::string
      layout;  ///< of AEDAT 2.0's addresses: "dvs128", "stereo", "dvs640", "davis", or empty where it is none of them
  std::optional<ImageSize> size;
};

/// jAER's `eu.seebetter.ini.chips.davis.DAVIS240C`, libcaer's `DAVIS346`, aedat4to2's `DAVI346`, and our own `DAVIS 304x240`.
/// Unknown are chips of other layouts (cochleas, multicamera rigs, DVS1280x720SD), and the size of some of the DAVIS family.
[[nodiscard]] AedatChip parse_aedat_chip(std::string_view name);

}  // namespace saccade
