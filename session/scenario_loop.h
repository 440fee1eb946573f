#pragma once

#include <optional>
#include <vector>

#include "config/scenario.h"
#include "loop/loop.h"

namespace saccade {

/// The parts of a loop as a scenario describes them.

[[nodiscard]] std::vector<LoopDetector> make_detectors(const NamedDetectors& named, const Camera& camera);

/// The limits of a head, with the head as gaze control aims it: its eyes' frames at the cameras of the assumed calibration.
[[nodiscard]] JointLimits aiming_limits(const Scenario& scenario, JointLimits limits);

/// None if nothing moves the head. `limits`: of the head.
[[nodiscard]] std::optional<LoopGaze> make_gaze(const Scenario& scenario, const JointLimits& limits);

/// The whole loop on the simulated robot, which outlives it. `detectors` and `gaze`: of the scenario.
[[nodiscard]] Loop make_loop(const Scenario& scenario, SimRobot& robot, std::vector<LoopDetector> detectors,
                             std::optional<LoopGaze> gaze);
[[nodiscard]] Loop make_loop(const Scenario& scenario, SimRobot& robot);

/// Sets the number of threads of OpenGL's software renderer; 1: the calling thread alone. Takes effect with the first
/// GlContext of its kind that is created afterwards. No other thread may be running.
void set_rasterisers(std::int64_t threads);

}  // namespace saccade
