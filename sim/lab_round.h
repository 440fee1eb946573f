#pragma once

#include <cstdint>

#include "sim/lab.h"
#include "sim/lab_layout.h"

namespace saccade::lab {

/// Adds the round things of config.round to a layout that is not packed yet: discs, clocks and wheels on the wall in front,
/// cups and balls on boards before it. Their places follow from the seed and do not depend on the rest of the lab.
void add_round_things(Layout& layout, const RoundThings& round, std::uint64_t seed);

}  // namespace saccade::lab
