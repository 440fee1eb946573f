#pragma once

#include <string>

#include "head/head_model.h"

namespace saccade {

/// MJCF of a head, made from its description: a body for each hinge of the chain, parallel to the root frame with all
/// joints at 0, position servos with the bandwidth and speed of the joints, a camera in each eye, and plain shapes that the
/// head's own cameras do not show. Links have no mass but that of the servos' rotors: gravity does not act on them.
[[nodiscard]] std::string described_head_mjcf(const HeadModel& head);

}  // namespace saccade
