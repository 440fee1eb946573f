#pragma once

#include <memory>

#include "apps/view/snapshot.h"

namespace saccade {

class SimRobot;
class World;

/// Ground truth and gaze target of a simulated run's newest tick. `camera`: the true camera of the left eye.
[[nodiscard]] SnapshotTruth simulated_truth(const SimRobot& robot, const Camera& camera, const Tick& tick);

/// A copy of a world's model with its textures, which snapshots share and which outlives the world.
/// Throws RunError when there is no memory for it.
[[nodiscard]] std::shared_ptr<const mjModel> copy_of_model(const World& world);

/// Fills image, model and scene of a snapshot. `model`: of the robot's world, as copy_of_model() returns it.
void fill_simulated(const SimRobot& robot, const std::shared_ptr<const mjModel>& model, Snapshot& snapshot);

/// Angle between the optical axis of a camera and the direction to the ball's centre, deg.
[[nodiscard]] float gaze_error_deg(const Eigen::Isometry3d& root_from_cam, const Eigen::Vector3d& ball_m);

}  // namespace saccade
