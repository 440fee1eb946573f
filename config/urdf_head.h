#pragma once

#include "head/placed_joints.h"

namespace saccade {

/// The chain of a head from a model in URDF. Joints beside those of the request stay at 0. Limits and speeds that the file
/// does not state, and speeds of 0 or above the largest of a described head, are NaN. Throws InputError with all that is wrong,
/// each with line and element: links and joints that do not exist, are there twice or do not connect, joints of another kind
/// than revolute and continuous, joints that mimic others, numbers that are none.
[[nodiscard]] PlacedChain chain_of_urdf(const ChainRequest& request);

}  // namespace saccade
