#pragma once

#include "head/placed_joints.h"

namespace saccade {

/// The chain of a head from a model in MJCF, as MuJoCo compiles it. A camera is a `<camera>`, or a body of that name. The base
/// is a body; without one the world, or the body that floats in it and carries the camera. Hinges of the request are at 0, all other joints as the
/// model has them. Ranges of joints without limits, and all speeds, are NaN. Throws InputError with the file's path: for a file
/// that MuJoCo rejects, names that do not exist or do not connect, joints that are no hinges or follow others by an equality,
/// cameras that turn to a target.
[[nodiscard]] PlacedChain chain_of_mjcf(const ChainRequest& request);

}  // namespace saccade
