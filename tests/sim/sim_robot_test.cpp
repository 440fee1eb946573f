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

/// A colour picture at `t_us`, its pixels shifted.
std::vector<float> colours_of(SimRobot& robot, std::int64_t t_us, const Eigen::Vector2d& shift_px) {
  const PinholeCamera camera = small_world().camera;
  std::vector<float> rgb(3 * static_cast<std::size_t>(camera.size.pixels()));
  robot.draw_left_eye(t_us, camera, shift_px, rgb);
  return rgb;
}

TEST(SimRobot, TheColourPictureOfTheLeftEyeHasTheLuminanceOfItsImage) {
  SimRobot robot(small_world(), 1);
  robot.wait_until(150'000);
  const std::vector<float> rgb = colours_of(robot, robot.now_us(), {0, 0});
  const std::span<const float> luminance = robot.left_image();
  for (std::size_t i = 0; i < luminance.size(); ++i) {
    const float sum =
        0.2126F * rgb[i] + 0.7152F * rgb[i + luminance.size()] + 0.0722F * rgb[i + 2 * luminance.size()];
    ASSERT_NEAR(sum, luminance[i], 1e-3) << "pixel " << i;
  }
}

TEST(SimRobot, AColourPictureShiftedByAPixelIsTheSamePictureOnePixelOn) {
  SimRobot robot(small_world(), 1);
  const std::vector<float> here = colours_of(robot, 0, {0, 0});
  const std::vector<float> right = colours_of(robot, 0, {1, 0});
  const std::vector<float> below = colours_of(robot, 0, {0, 1});
  int differ = 0;
  for (std::size_t y = 0; y + 1 < 64; ++y) {
    for (std::size_t x = 0; x + 1 < 64; ++x) {
      differ += std::abs(right[y * 64 + x] - here[y * 64 + x + 1]) > 2.0F;
      differ += std::abs(below[y * 64 + x] - here[(y + 1) * 64 + x]) > 2.0F;
    }
  }
  std::printf("%d of %d values differ\n", differ, 2 * 63 * 63);
  EXPECT_LT(differ, 2 * 63 * 63 / 100);  // edges that fall on the other side of a sample by rounding
}

TEST(SimRobot, BetweenTicksTheColourPictureShowsTheBallOnItsWay) {
  SimRobot robot(small_world(), 1);
  robot.wait_until(150'000);
  const std::vector<float> end = colours_of(robot, 150'000, {0, 0});
  const auto change = [&](std::int64_t t_us) {
    const std::vector<float> then = colours_of(robot, t_us, {0, 0});
    double sum = 0.0;
    for (std::size_t i = 0; i < end.size(); ++i) sum += std::abs(then[i] - end[i]);
    return sum;
  };
  EXPECT_EQ(change(150'000), 0.0);
  EXPECT_GT(change(149'100), change(149'700));
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
