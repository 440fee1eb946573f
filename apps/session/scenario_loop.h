#pragma once

#include <optional>
#include <vector>

#include "apps/config/scenario.h"
#include "loop/loop.h"

namespace saccade {

/// The parts of a loop as a scenario asks for them.

[[nodiscard]] std::vector<LoopDetector> make_detectors(const NamedDetectors& named, const Camera& camera);

/// None where nothing moves the head. `limits` are the head's.
[[nodiscard]] std::optional<LoopGaze> make_gaze(const Scenario& scenario, const JointLimits& limits);

/// The whole of it, around its robot, which outlives it.
[[nodiscard]] Loop make_loop(const Scenario& scenario, SimRobot& robot);

/// How many threads OpenGL's software renderer may draw with, 1 the calling one alone: what the next GlContext that is
/// the first of its kind goes by. No other thread may be running.
void set_rasterisers(std::int64_t threads);

}  // namespace saccade
