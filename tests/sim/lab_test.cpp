#include "sim/lab.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

class LabOf : public ::testing::TestWithParam<Clutter> {
 protected:
  LabConfig config() const { return {.clutter = GetParam()}; }

  static MjModelPtr compile(const std::string& elements) {
    const MjVfsPtr vfs(new mjVFS);
    mj_defaultVFS(vfs.get());
    EXPECT_TRUE(add_to_vfs(vfs.get(), "lab.xml", "<mujoco>" + elements + "</mujoco>"));
    std::array<char, 1000> error{};
    MjModelPtr model(mj_loadXML("lab.xml", vfs.get(), error.data(), static_cast<int>(error.size())));
    EXPECT_NE(model, nullptr) << error.data();
    return model;
  }
  static std::vector<mjtByte> pixels(const mjModel& model) {
    return {texels_of(model, 0), texels_of(model, 0) + model.ntexdata};
  }
};

TEST_P(LabOf, IsTheSameForTheSameSeedAndDiffersForAnother) {
  const std::string text = Lab(config(), 7).mjcf();
  EXPECT_EQ(Lab(config(), 7).mjcf(), text);
  EXPECT_NE(Lab(config(), 8).mjcf(), text);

  const MjModelPtr first = compile(text);
  const MjModelPtr second = compile(text);
  const std::vector<mjtByte> flat = pixels(*first);
  Lab(config(), 7).paint(*first);
  EXPECT_NE(pixels(*first), flat);
  Lab(config(), 7).paint(*second);
  EXPECT_EQ(pixels(*first), pixels(*second));
}

TEST_P(LabOf, IsOneGeomWithoutCollisionsInAGroupThatTheEyesDraw) {
  const MjModelPtr model = compile(Lab(config(), 1).mjcf());
  ASSERT_EQ(model->ngeom, 1);
  EXPECT_EQ(model->geom_contype[0], 0);
  EXPECT_EQ(model->geom_conaffinity[0], 0);
  EXPECT_EQ(model->geom_group[0], 1);
  EXPECT_EQ(model->nlight, 2);
}

TEST_P(LabOf, StaysOutOfTheRobotsReachAndInsideItsWalls) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const double distance : {1.8, 2.2, 4.0}) {
      LabConfig lab = config();
      lab.wall_distance_m = distance;
      const MjModelPtr model = compile(Lab(lab, seed).mjcf());
      // MuJoCo stores a mesh in a frame of its own; the geom's pose converts it to the root frame.
      std::array<mjtNum, 9> turn{};
      mju_quat2Mat(turn.data(), model->geom_quat);
      double nearest = 1e9;
      for (int i = 0; i < model->nmeshvert; ++i) {
        const std::array<mjtNum, 3> local{model->mesh_vert[3 * i], model->mesh_vert[3 * i + 1],
                                          model->mesh_vert[3 * i + 2]};
        std::array<mjtNum, 3> root{};
        mju_mulMatVec(root.data(), turn.data(), local.data(), 3, 3);
        mju_addTo(root.data(), model->geom_pos, 3);
        EXPECT_GT(root[0], -distance - 0.2);
        EXPECT_LT(root[0], 1.9);
        if (root[2] > -0.5 && root[2] < 1.0 && std::abs(root[1]) < 0.5 && root[0] < 0.0) {
          nearest = std::min(nearest, -root[0]);
        }
      }
      EXPECT_GT(nearest, 0.6) << "seed " << seed << ", wall at " << distance;
    }
  }
}

TEST_P(LabOf, IsPaintedBetweenItsLimitsAndInOneColourWithoutContrast) {
  LabConfig lab = config();
  for (const double contrast : {0.0, 1.0, 1.5}) {
    lab.contrast = contrast;
    const MjModelPtr model = compile(Lab(lab, 2).mjcf());
    Lab(lab, 2).paint(*model);
    const std::vector<mjtByte> all = pixels(*model);
    const auto [low, high] = std::minmax_element(all.begin(), all.end());
    EXPECT_GE(*low, 23);    // 0.09
    EXPECT_LE(*high, 235);  // 0.92
    if (contrast == 0.0) {
      EXPECT_EQ(*low, *high);
    } else {
      EXPECT_GT(*high - *low, GetParam() == Clutter::bare ? 100 : 150);
    }
  }
}

TEST_P(LabOf, HasMoreFacesWithAHigherDensity) {
  LabConfig lab = config();
  std::size_t before = 0;
  for (const double density : {0.0, 1.0, 2.0}) {
    lab.density = density;
    const MjModelPtr model = compile(Lab(lab, 4).mjcf());
    Lab(lab, 4).paint(*model);
    const auto faces = static_cast<std::size_t>(model->nmeshface);
    EXPECT_GT(faces, before);
    before = faces;
  }
}

TEST_P(LabOf, HasRoundThingsInsideItsWallsAndLeavesTheRestAsItIs) {
  LabConfig lab = config();
  const MjModelPtr without = compile(Lab(lab, 3).mjcf());
  lab.round = {.discs = 2, .clocks = 1, .wheels = 1, .cups = 2, .balls = 1};
  const MjModelPtr with = compile(Lab(lab, 3).mjcf());
  // 32 triangles for a disc, 3 x 32 for a cup and 12 for its board, 2 x 15 x 32 for a ball and 12 for its board.
  EXPECT_EQ(with->nmeshface, without->nmeshface + 4 * 32 + 2 * (96 + 12) + 960 + 12);
  Lab(lab, 3).paint(*with);
}

TEST_P(LabOf, HasPrintedShapesAndLeavesTheRestAsItIs) {
  LabConfig lab = config();
  const MjModelPtr without = compile(Lab(lab, 3).mjcf());
  lab.shapes = 5;
  const MjModelPtr with = compile(Lab(lab, 3).mjcf());
  EXPECT_EQ(with->nmeshface, without->nmeshface + 5 * 12);  // a panel is a cuboid
  Lab(lab, 3).paint(*with);
}

TEST_P(LabOf, RejectsToPaintTheModelOfAnotherLab) {
  LabConfig longer = config();
  longer.wall_distance_m = 3.5;
  const MjModelPtr model = compile(Lab(longer, 1).mjcf());
  EXPECT_THROW(Lab(config(), 1).paint(*model), RunError);
}

INSTANTIATE_TEST_SUITE_P(Clutter, LabOf,
                         ::testing::Values(Clutter::textured, Clutter::rectilinear, Clutter::natural,
                                           Clutter::foliage, Clutter::blinds, Clutter::shelves,
                                           Clutter::bare),
                         [](const auto& parameter) { return std::string(word_of(parameter.param)); });

TEST(LabConfig, IsRejectedWhenOutOfRange) {
  EXPECT_THROW(Lab(LabConfig{.clutter = Clutter{7}}, 1), InputError);
  EXPECT_THROW(Lab(LabConfig{.density = -1.0}, 1), InputError);
  EXPECT_THROW(Lab(LabConfig{.wall_distance_m = 0.3}, 1), InputError);
}

}  // namespace
}  // namespace saccade
