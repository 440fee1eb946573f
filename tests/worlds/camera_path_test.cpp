#include "worlds/camera_path.h"

#include <gtest/gtest.h>

#include "head/icub_cameras.h"
#include "worlds/outline_contrast.h"

namespace saccade {
namespace {

constexpr std::uint64_t path_seed = 5;

/// A ball that rests ahead of the eye at that distance, m.
TrajectoryConfig resting(const CameraPath& path, double distance_m) {
  const Eigen::Isometry3d& eye = path.root_from_eye().front();
  TrajectoryConfig config;
  config.points_m = {eye * Eigen::Vector3d(0.0, 0.0, distance_m)};
  config.sway_m = 0.0;
  return config;
}

TEST(CameraPath, WithoutAScriptTheEyeRests) {
  const CameraPath path(nullptr, WorldConfig{}, 1.0);
  ASSERT_EQ(path.root_from_eye().size(), 101U) << "every 10 ms, both ends";
  for (const Eigen::Isometry3d& pose : path.root_from_eye())
    EXPECT_TRUE(pose.isApprox(path.root_from_eye().front()));
}

TEST(BallView, OfABallAheadIsItsProjection) {
  const CameraPath path(nullptr, WorldConfig{}, 0.5);
  const Trajectory ball(resting(path, 0.5), path_seed);
  const BallView view = view_of(path, icub_left_2016, ball, 0.03, {}, path_seed);
  EXPECT_EQ(view.in_view_share, 1.0);
  EXPECT_EQ(view.hidden_share, 0.0);
  const double expected_px = icub_left_2016.project_sphere({0.0, 0.0, 0.5}, 0.03)->r_px;
  EXPECT_NEAR(view.smallest_px, expected_px, 0.05 * expected_px);
  EXPECT_NEAR(view.largest_px, expected_px, 0.05 * expected_px);
  EXPECT_NEAR(view.fastest_px_s, 0.0, 1e-6);
}

TEST(BallView, OfABallBehindTheCameraIsEmpty) {
  const CameraPath path(nullptr, WorldConfig{}, 0.5);
  const Trajectory ball(resting(path, -0.5), path_seed);
  EXPECT_EQ(view_of(path, icub_left_2016, ball, 0.03, {}, path_seed).in_view_share, 0.0);
}

TEST(OutlineContrast, IsAShareAndNoneForABallOutOfView) {
  const CameraPath path(nullptr, WorldConfig{}, 0.2);
  const LabConfig lab;
  const auto share = [&](double distance_m, double on) {
    const OutlineContrast contrast(lab, path_seed, path, icub_left_2016,
                                   Trajectory(resting(path, distance_m), path_seed), 0.03);
    EmulatorConfig sensor;
    sensor.contrast_threshold_on = sensor.contrast_threshold_off = on;
    return contrast.share(BallConfig{}, sensor);
  };
  EXPECT_GT(share(0.5, 0.01), 0.8) << "nearly any difference counts";
  EXPECT_EQ(share(0.5, 20.0), 0.0) << "none does";
  EXPECT_EQ(share(-0.5, 0.01), 0.0) << "behind the camera";
}

}  // namespace
}  // namespace saccade
