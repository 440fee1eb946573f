#pragma once

#include <optional>

#include "apps/live/live_feed.h"
#include "core/camera.h"
#include "sim/sim_robot.h"

namespace saccade {

/// What the page of a simulated run shows of the ground truth at the newest tick. `camera`: the true left one.
[[nodiscard]] LiveTruth live_truth(const SimTruth& truth, const Camera& camera,
                                   const std::optional<Eigen::Vector3d>& target_m);

}  // namespace saccade
