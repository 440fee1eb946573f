#pragma once

#include <optional>
#include <vector>

#include "apps/config/scenario.h"
#include "apps/loop.h"

namespace saccade {

/// The parts of a loop as a scenario asks for them.

[[nodiscard]] std::vector<LoopDetector> make_detectors(const NamedDetectors& named, const Camera& camera);

/// None where nothing moves the head. `limits` are the head's.
[[nodiscard]] std::optional<LoopGaze> make_gaze(const Scenario& scenario, const JointLimits& limits);

}  // namespace saccade
