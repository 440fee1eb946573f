// A turning eye in a still room: the flow computed from the simulated events must equal the motion of the image.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/flow/plane_fit_flow.h"
#include "emulator/event_emulator.h"
#include "head/icub_cameras.h"
#include "sim/eye_renderer.h"
#include "sim/lab.h"
#include "sim/world.h"

namespace saccade {
namespace {

/// Turns the left eye's camera in `data` about the image's vertical axis: to the right in the image.
void pan(mjData& data, int camera, const Eigen::Matrix3d& at_rest, double angle_rad) {
  // MuJoCo's cameras have x right, y up and look along -z.
  const Eigen::Matrix3d turned = at_rest * Eigen::AngleAxisd(-angle_rad, Eigen::Vector3d::UnitY());
  Eigen::Map<Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>>(data.cam_xmat + 9 * camera) = turned;
}

TEST(EgoMotion, FlowOfAPurePanIsThatOfTheTurn) {
  LabConfig lab_config;
  lab_config.clutter = Clutter::rectilinear;  // straight edges give planes of time stamps
  const Lab lab(lab_config, 1);
  WorldConfig config;
  config.ball.trajectory.sway_m = 0.0;
  World world(config, lab.mjcf(), 1);
  const auto gl = GlContext::create("auto");
  lab.paint(world.model());
  const Camera camera = icub_left_2016;
  EyeRenderConfig fine;
  fine.supersampling = 4;
  EyeRenderer eye(world.model(), *gl, camera, fine);
  EmulatorConfig first_of_an_edge = emulator_preset("ideal");
  first_of_an_edge.dark_current = 10.0;
  first_of_an_edge.refractory_us = 20'000;  // later crossings would hide the time of the first
  EventEmulator emulator(first_of_an_edge, camera.size, 1);
  PlaneFitFlow flow({}, camera.size);

  const double turn_rad_s = 1.5;
  const int id = world.left_eye_camera();
  const Eigen::Matrix3d at_rest =
      Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>>(world.data().cam_xmat + 9 * id);
  std::vector<float> image(static_cast<std::size_t>(camera.size.pixels()));
  std::vector<Event> events;
  std::vector<double> ratios;
  std::size_t used = 0;
  for (std::int64_t t_us = 0; t_us <= 100'000; t_us += 1000) {
    pan(world.data(), id, at_rest, turn_rad_s * (static_cast<double>(t_us) * 1e-6 - 0.05));
    eye.render(world.data(), id, image);
    emulator.process_image(image, t_us, events);
    for (; used < events.size(); ++used) {
      const Event& e = events[used];
      flow.add(e);
      const auto normal = flow.at(e);
      if (!normal || t_us < 40'000) continue;
      // About the camera's y axis, which points down.
      const Eigen::Vector2d true_px_s =
          camera.rotational_flow_px_s(camera.ray(e.x, e.y), {0.0, turn_rad_s, 0.0});
      const Eigen::Vector2d slope_s_px = 1e-6 * Eigen::Vector2d(normal->dt_dx_us_px, normal->dt_dy_us_px);
      const Eigen::Vector2d direction = slope_s_px.normalized();
      const double along_px_s = true_px_s.dot(direction);
      if (along_px_s < 0.8 * true_px_s.norm()) continue;  // edges along the motion give little information
      ratios.push_back(1.0 / slope_s_px.norm() / along_px_s);
    }
  }
  ASSERT_GT(ratios.size(), 1000U);
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  std::printf("pan of %.1f rad/s: %zu flows, median of their speed over omega f: %.4f\n", turn_rad_s,
              ratios.size(), *middle);
  EXPECT_NEAR(*middle, 1.0, 0.02);
}

class StillHead : public testing::TestWithParam<Clutter> {};

TEST_P(StillHead, MakesNoEventInAStillRoomWithoutNoise) {
  LabConfig lab_config;
  lab_config.clutter = GetParam();
  const Lab lab(lab_config, 1);
  WorldConfig config;
  config.ball.trajectory.sway_m = 0.0;
  World world(config, lab.mjcf(), 1);
  const auto gl = GlContext::create("auto");
  lab.paint(world.model());
  const Camera camera = icub_left_2016;
  EyeRenderer eye(world.model(), *gl, camera, {});
  EventEmulator emulator(emulator_preset("ideal"), camera.size, 1);
  std::vector<float> image(static_cast<std::size_t>(camera.size.pixels()));
  std::vector<Event> events;
  for (int k = 0; k < 100; ++k) {
    eye.render(world.data(), world.left_eye_camera(), image);
    emulator.process_image(image, k * 1000, events);
  }
  EXPECT_TRUE(events.empty());
}

INSTANTIATE_TEST_SUITE_P(Lab, StillHead, testing::Values(Clutter::textured, Clutter::rectilinear),
                         [](const auto& lab) { return std::string(word_of(lab.param)); });

}  // namespace
}  // namespace saccade
