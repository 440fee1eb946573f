#include "core/flow/camera_rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/random.h"

namespace saccade {
namespace {

constexpr Camera rotation_camera{{128, 96}, 110.0, 108.0, 63.0, 47.5};

std::vector<Eigen::Vector3d> rays() {
  std::vector<Eigen::Vector3d> rays;
  for (int y = 0; y < rotation_camera.size.height; ++y) {
    for (int x = 0; x < rotation_camera.size.width; ++x) rays.push_back(rotation_camera.ray(x, y));
  }
  return rays;
}

/// Normal flows that a rotation makes at random edges in the left `width_px` pixels of the image; a share of them, the first
/// ones, has flows of its own.
std::vector<FlowSample> flows_of(const Eigen::Vector3d& rotation_rad_s, int count, double share_of_others,
                                 int width_px = rotation_camera.size.width) {
  const RandomStream random(1, "flows");
  std::vector<FlowSample> flows;
  for (int i = 0; i < count; ++i) {
    const auto n = static_cast<std::uint64_t>(i);
    const auto x = static_cast<std::uint16_t>(random.uniform(0, n) * width_px);
    const auto y = static_cast<std::uint16_t>(random.uniform(1, n) * rotation_camera.size.height);
    const double angle = random.uniform(0.0, 6.28, 2, n);
    Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    double speed = along.dot(rotation_camera.rotational_flow_px_s(rotation_camera.ray(x, y), rotation_rad_s));
    if (i < share_of_others * count) speed = random.uniform(-800.0, 800.0, 3, n);
    if (speed < 0.0) {  // an edge moves along its flow
      along = -along;
      speed = -speed;
    }
    flows.push_back({x, y, along, speed});
  }
  return flows;
}

TEST(CameraRotation, IsThatWhichMadeTheFlows) {
  const Eigen::Vector3d rotation(0.6, -1.0, 0.8);
  const Eigen::Vector3d found =
      camera_rotation(flows_of(rotation, 500, 0.0), rotation_camera, rays(), Eigen::Vector3d::Zero());
  EXPECT_LT((found - rotation).norm(), 0.01) << found.transpose();
}

TEST(CameraRotation, IgnoresEdgesThatMoveOtherwise) {
  const Eigen::Vector3d rotation(0.6, -1.0, 0.8);
  const Eigen::Vector3d found =
      camera_rotation(flows_of(rotation, 800, 0.3), rotation_camera, rays(), Eigen::Vector3d::Zero());
  EXPECT_LT((found - rotation).norm(), 0.1) << found.transpose();
}

TEST(CameraRotation, IsZeroWhereTooFewEdgesAgreeOrTheyLieInOnePart) {
  const Eigen::Vector3d rotation(0.6, -1.0, 0.8);
  const auto zero = Eigen::Vector3d::Zero();
  EXPECT_TRUE(camera_rotation(flows_of(rotation, 800, 0.9), rotation_camera, rays(), zero).isZero());
  EXPECT_TRUE(camera_rotation(flows_of(rotation, 800, 0.0, 50), rotation_camera, rays(), zero).isZero());
  EXPECT_TRUE(camera_rotation(flows_of(rotation, 20, 0.0), rotation_camera, rays(), zero).isZero());
  EXPECT_TRUE(camera_rotation({}, rotation_camera, rays(), zero).isZero());
}

}  // namespace
}  // namespace saccade
