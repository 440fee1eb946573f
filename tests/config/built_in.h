#pragma once

#include "apps/config/registry.h"

namespace saccade {

/// What saccade ships, as far as reading files needs it.
inline Registry built_in() { return {built_in_detectors(), built_in_controllers(), built_in_gates()}; }

}  // namespace saccade
