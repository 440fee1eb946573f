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

class Lab : public ::testing::TestWithParam<const char*> {
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
#if mjVERSION_HEADER >= 320
    return {model.tex_data, model.tex_data + model.ntexdata};
#else
    return {model.tex_rgb, model.tex_rgb + model.ntexdata};
#endif
  }
};

TEST_P(Lab, is_the_same_for_the_same_seed_and_another_for_another) {
  const std::string text = lab_mjcf(config(), 7);
  EXPECT_EQ(lab_mjcf(config(), 7), text);
  EXPECT_NE(lab_mjcf(config(), 8), text);

  const MjModelPtr first = compile(text);
  const MjModelPtr second = compile(text);
  const std::vector<mjtByte> flat = pixels(*first);
  paint_lab_textures(*first, config(), 7);
  EXPECT_NE(pixels(*first), flat);
  paint_lab_textures(*second, config(), 7);
  EXPECT_EQ(pixels(*first), pixels(*second));
}

TEST_P(Lab, is_one_geom_that_touches_nothing_and_that_the_eyes_see) {
  const MjModelPtr model = compile(lab_mjcf(config(), 1));
  ASSERT_EQ(model->ngeom, 1);
  EXPECT_EQ(model->geom_contype[0], 0);
  EXPECT_EQ(model->geom_conaffinity[0], 0);
  EXPECT_EQ(model->geom_group[0], 1);
  EXPECT_EQ(model->nlight, 2);
}

TEST_P(Lab, stays_clear_of_the_robots_reach_and_inside_its_walls) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const double distance : {1.8, 2.2, 4.0}) {
      LabConfig lab = config();
      lab.wall_distance_m = distance;
      const MjModelPtr model = compile(lab_mjcf(lab, seed));
      // MuJoCo keeps a mesh in a frame of its own; the geom's pose leads back to the root.
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

TEST_P(Lab, is_painted_between_its_limits_and_flat_without_contrast) {
  LabConfig lab = config();
  for (const double contrast : {0.0, 1.0, 1.5}) {
    lab.contrast = contrast;
    const MjModelPtr model = compile(lab_mjcf(lab, 2));
    paint_lab_textures(*model, lab, 2);
    const std::vector<mjtByte> all = pixels(*model);
    const auto [low, high] = std::minmax_element(all.begin(), all.end());
    EXPECT_GE(*low, 23);    // 0.09
    EXPECT_LE(*high, 235);  // 0.92
    if (contrast == 0.0) {
      EXPECT_EQ(*low, *high);
    } else {
      EXPECT_GT(*high - *low, 150);
    }
  }
}

TEST_P(Lab, is_fuller_when_denser) {
  LabConfig lab = config();
  std::size_t before = 0;
  for (const double density : {0.0, 1.0, 2.0}) {
    lab.density = density;
    const MjModelPtr model = compile(lab_mjcf(lab, 4));
    paint_lab_textures(*model, lab, 4);
    const auto faces = static_cast<std::size_t>(model->nmeshface);
    EXPECT_GT(faces, before);
    before = faces;
  }
}

TEST_P(Lab, refuses_a_model_of_another_lab) {
  LabConfig denser = config();
  denser.density = 2.0;
  const MjModelPtr model = compile(lab_mjcf(denser, 1));
  EXPECT_THROW(paint_lab_textures(*model, config(), 1), RunError);
}

INSTANTIATE_TEST_SUITE_P(Clutter, Lab, ::testing::Values("textured", "rectilinear"),
                         [](const auto& parameter) { return std::string(parameter.param); });

TEST(LabConfig, is_refused_when_out_of_range) {
  EXPECT_THROW(static_cast<void>(lab_mjcf({.clutter = "empty"}, 1)), InputError);
  EXPECT_THROW(static_cast<void>(lab_mjcf({.density = -1.0}, 1)), InputError);
  EXPECT_THROW(static_cast<void>(lab_mjcf({.wall_distance_m = 0.3}, 1)), InputError);
}

}  // namespace
}  // namespace saccade
