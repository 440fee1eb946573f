#include "apps/view/sim_snapshot.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"
#include "sim/sim_robot.h"

namespace saccade {

float gaze_error_deg(const Eigen::Isometry3d& root_from_cam, const Eigen::Vector3d& ball_m) {
  const Eigen::Vector3d to_ball = ball_m - root_from_cam.translation();
  const Eigen::Vector3d axis = root_from_cam.linear().col(2);
  return static_cast<float>(deg_per_rad * std::atan2(axis.cross(to_ball).norm(), axis.dot(to_ball)));
}

SnapshotTruth simulated_truth(const SimRobot& robot, const Camera& camera, const Tick& tick) {
  const SimTruth& truth = robot.truth();
  SnapshotTruth shown;
  if (truth.left.visible > 0.0) shown.circle = truth.left.circle;
  if (const auto& extent = truth.left.extent) {
    const Eigen::Vector2d corner_px = extent->corner_px.array() - 0.5;
    shown.box_px = {corner_px, corner_px + extent->size_px};
  }
  shown.root_from_cam = truth.left.root_from_cam;
  shown.gaze_error_deg = gaze_error_deg(truth.left.root_from_cam, truth.ball_m);
  shown.target_m = tick.target_m;
  if (tick.target_m) shown.target_px = camera.project(truth.left.root_from_cam.inverse() * *tick.target_m);
  return shown;
}

std::shared_ptr<const mjModel> copy_of_model(const World& world) {
  MjModelPtr copy(mj_copyModel(nullptr, &world.model()));
  if (!copy) throw RunError("MuJoCo has no memory for a copy of the world's model");
  return copy;
}

void fill_simulated(const SimRobot& robot, const std::shared_ptr<const mjModel>& model, Snapshot& snapshot) {
  const std::span<const float> image = robot.left_eye().image();
  snapshot.grey.resize(image.size());
  std::ranges::transform(image, snapshot.grey.begin(), [](float grey) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0F, 255.0F)));
  });
  snapshot.use_model(model);
  mj_copyData(snapshot.scene.get(), model.get(), &robot.world().data());
}

}  // namespace saccade
