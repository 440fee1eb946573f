#include "sim/sim_robot.h"

#include <gtest/gtest.h>

#include "tests/robot/port_conformance.h"

namespace saccade {
namespace {

/// A coarse eye, so that many runs cost little, and a ball that moves fast.
SimConfig small_world() {
  SimConfig config;
  config.camera = PinholeCamera{{64, 64}, 50.0, 50.0, 31.5, 31.5};
  config.render.supersampling = 1;
  config.world.ball.trajectory.kind = "circle";
  config.world.ball.trajectory.frequency_hz = 2.0;
  return config;
}

SimConfig still_world() {
  SimConfig config = small_world();
  config.world.ball.trajectory = TrajectoryConfig{};
  config.world.ball.trajectory.sway_m = 0.0;
  return config;
}

RobotUnderTest simulated() {
  auto robot = std::make_shared<SimRobot>(small_world(), 1);
  return {robot, robot.get(), robot.get(), robot.get()};
}

INSTANTIATE_TEST_SUITE_P(Sim, PortConformance, testing::Values(PortBackend{"Sim", simulated}),
                         name_of_backend);

TEST(SimRobot, AStillHeadBeforeAStillSceneSeesNoEvent) {
  SimRobot robot(still_world(), 3);
  HeadState state;
  robot.read(state);
  std::vector<Event> events;
  // The head sags by hundredths of a degree while its servos take the load; then nothing moves.
  robot.wait_until(500'000);
  robot.read_until(500'000, events);
  events.clear();
  robot.wait_until(1'500'000);
  robot.read_until(1'500'000, events);
  EXPECT_EQ(events.size(), 0U);
}

TEST(SimRobot, TruthIsTheProjectionOfTheBallThroughThePlantsEye) {
  SimRobot robot(small_world(), 1);
  const PinholeCamera camera = small_world().camera;
  for (std::int64_t t_us = 1000; t_us <= 400'000; t_us += 1000) {
    robot.wait_until(t_us);
    const SimTruth& truth = robot.truth();
    ASSERT_EQ(truth.t_us, t_us);
    const Eigen::Vector3d in_cam_m = truth.root_from_left_cam.inverse() * truth.ball_m;
    const auto circle = camera.project_sphere(in_cam_m, 0.0475);
    ASSERT_TRUE(circle && truth.circle);
    EXPECT_NEAR(circle->x_px, truth.circle->x_px, 1e-12);
    EXPECT_NEAR(circle->r_px, truth.circle->r_px, 1e-12);
    EXPECT_GT(truth.visible, 0.8);
  }
}

TEST(SimRobot, EventsOfAMovingBallLieAtItsOutlineOrItsHand) {
  SimConfig config = small_world();
  config.lab.contrast = 0.0;
  SimRobot robot(config, 1);
  robot.wait_until(300'000);
  std::vector<Event> before;
  robot.read_until(300'000, before);
  std::vector<Event> events;
  robot.wait_until(310'000);
  robot.read_until(310'000, events);
  ASSERT_GT(events.size(), 20U);
  const Circle ball = *robot.truth().circle;
  int near = 0;
  for (const Event& e : events) {
    // Within the ball's disc and a margin for 10 ms of motion; the hand hangs below and to the sides.
    near += std::hypot(e.x - ball.x_px, e.y - ball.y_px) < ball.r_px + 3.0;
  }
  std::printf("%d of %zu events within 3 px of the ball's disc\n", near, events.size());
  EXPECT_GT(near, static_cast<int>(events.size()) / 3);
}

}  // namespace
}  // namespace saccade
