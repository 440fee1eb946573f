#include "apps/live/live_truth.h"

#include <cmath>

#include "core/units.h"

namespace saccade {

LiveTruth live_truth(const SimTruth& truth, const Camera& camera,
                     const std::optional<Eigen::Vector3d>& target_m) {
  LiveTruth live;
  live.circle = truth.left.circle;
  live.visible = truth.left.visible;
  const Eigen::Isometry3d& eye = truth.left.root_from_cam;
  const Eigen::Vector3d to_ball = truth.ball_m - eye.translation();
  const Eigen::Vector3d axis = eye.linear().col(2);
  live.gaze_error_deg = std::atan2(axis.cross(to_ball).norm(), axis.dot(to_ball)) * deg_per_rad;
  if (target_m) live.target_px = camera.project(eye.inverse() * *target_m);
  return live;
}

}  // namespace saccade
