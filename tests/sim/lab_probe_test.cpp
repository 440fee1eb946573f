#include "sim/lab_probe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/error.h"
#include "sim/sim_robot.h"

namespace saccade {
namespace {

// Rays through single points against pixels of 2 x 2 samples and interpolated texels: at most pixels the two agree to
// some percent, at edges they do not.
TEST(LabProbe, SeesWhatTheEyeSees) {
  for (const auto& [clutter, word] : words_of(Clutter{})) {
    SimConfig config;
    config.camera = config.camera.without_lens();
    config.lab.clutter = clutter;
    config.lab.brightness = 0.6;
    config.lab.round = {2, 1, 1, 2, 2};
    config.lab.shapes = 3;
    config.world.ball.present = false;
    std::optional<SimRobot> robot;
    try {
      robot.emplace(config, 3);
    } catch (const RunError& error) {
      GTEST_SKIP() << "NOT TESTED, there is no OpenGL: " << error.what();
    }
    LabProbe probe(config.lab, 3);
    const Eigen::Isometry3d root_from_cam = robot->truth().left.root_from_cam;
    std::vector<double> differences;
    double mean = 0.0;
    for (int y = 2; y < 128; y += 5) {
      for (int x = 2; x < 128; x += 5) {
        const Eigen::Vector3d ray = root_from_cam.linear() * config.camera.ray(x, y);
        const double seen =
            static_cast<double>(robot->left_eye().image()[static_cast<std::size_t>(128 * y + x)]);
        differences.push_back(std::abs(255.0 * probe.luminance(root_from_cam.translation(), ray) - seen));
        mean += seen;
      }
    }
    mean /= static_cast<double>(differences.size());
    std::ranges::nth_element(differences,
                             differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2));
    EXPECT_LT(differences[differences.size() / 2], 0.1 * mean) << word;
    EXPECT_GT(mean, 30.0) << word;
  }
}

}  // namespace
}  // namespace saccade
