#pragma once

#include <cstdint>

#include "sim/lab.h"
#include "sim/lab_layout.h"

namespace saccade::lab {

/// The rooms that are their walls: natural, foliage, blinds, shelves, bare. The layout is not packed yet.
[[nodiscard]] Layout room_of_walls(const LabConfig& config, std::uint64_t seed);

}  // namespace saccade::lab
