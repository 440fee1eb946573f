#pragma once

#include <cstdint>

#include "sim/lab_layout.h"

namespace saccade::lab {

/// Adds `count` panels with a printed shape that is no disc to a layout that is not packed yet, on the wall in front: polygons
/// of 3 to 6 corners, stars, arrows, ellipses with axes below 0.8, and discs of which at most 60 % of the outline is left.
/// Their places follow from the seed and do not depend on the rest of the lab.
void add_printed_shapes(Layout& layout, std::int64_t count, std::uint64_t seed);

}  // namespace saccade::lab
