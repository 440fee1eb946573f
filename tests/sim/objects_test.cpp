#include "sim/objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "head/icub_cameras.h"
#include "sim/image_sampler.h"
#include "sim/world.h"

namespace saccade {
namespace {

constexpr double floor_m = -0.62;

ObjectConfig tin() {
  ObjectConfig tin;
  tin.shape = ObjectShape::cylinder;
  tin.size_m = {0.07, 0.07, 0.12};
  tin.trajectory.kind = TrajectoryKind::circle;
  tin.trajectory.centre_m = {-0.6, 0.0, 0.35};
  tin.trajectory.frequency_hz = 0.5;
  return tin;
}

ObjectConfig walker() {
  ObjectConfig walker;
  walker.shape = ObjectShape::person;
  walker.trajectory.kind = TrajectoryKind::waypoints;
  walker.trajectory.points_m = {{-1.4, -1.0, floor_m}, {-1.4, 1.0, floor_m}};
  walker.trajectory.speed_m_s = 1.0;
  walker.trajectory.sway_m = 0.0;
  return walker;
}

WorldConfig world_with(const NamedObjects& objects) {
  WorldConfig config;
  config.ball.trajectory.sway_m = 0.0;
  config.objects = objects;
  return config;
}

Eigen::Vector3d body_m(const World& world, const mjData& data, const char* name) {
  return Eigen::Map<const Eigen::Vector3d>(data.xpos + 3 * mj_name2id(&world.model(), mjOBJ_BODY, name));
}

TEST(Objects, AreAbsentUnlessConfigured) {
  const World without(world_with({}), "", 1);
  const World with(world_with({{"tin", tin()}, {"walker", walker()}}), "", 1);
  EXPECT_EQ(objects_mjcf({}, {}), "");
  EXPECT_EQ(with.model().ngeom, without.model().ngeom + 1 + 6);
  for (const std::uint8_t object : without.scene_objects()) {
    EXPECT_NE(object, static_cast<std::uint8_t>(SceneObject::distractor));
  }
}

TEST(Objects, FollowTheirTrajectoriesBetweenTicksToo) {
  World world(world_with({{"tin", tin()}, {"other", tin()}}), "", 5);
  const MjDataPtr between(mj_makeData(&world.model()));
  const Trajectory trajectory(tin().trajectory, 6);
  for (int tick = 0; tick < 500; ++tick) {
    world.step();
    ASSERT_LT((body_m(world, world.data(), "distractor_0_0") - trajectory.position_m(world.now_us())).norm(),
              1e-12);
    world.show(world.now_us() - 300, *between);
    ASSERT_LT(
        (body_m(world, *between, "distractor_0_0") - trajectory.position_m(world.now_us() - 300)).norm(),
        1e-12);
  }
  // The same trajectory in another hand has another sway.
  const double apart_m =
      (body_m(world, world.data(), "distractor_0_0") - body_m(world, world.data(), "distractor_1_0")).norm();
  EXPECT_GT(apart_m, 1e-5);
  EXPECT_LT(apart_m, 0.02);
}

TEST(Objects, AreDistractorsInTheLabels) {
  const World world(world_with({{"tin", tin()}, {"walker", walker()}}), "", 1);
  const auto objects = world.scene_objects();
  EXPECT_EQ(std::ranges::count(objects, static_cast<std::uint8_t>(SceneObject::distractor)), 7);
}

TEST(Objects, HaveTheConfiguredSize) {
  ObjectConfig box;
  box.size_m = {0.1, 0.2, 0.3};
  const World world(world_with({{"box", box}, {"tin", tin()}}), "", 1);
  const mjModel& m = world.model();
  const mjtNum* box_half = m.geom_size + 3 * m.body_geomadr[mj_name2id(&m, mjOBJ_BODY, "distractor_0_0")];
  const mjtNum* tin_half = m.geom_size + 3 * m.body_geomadr[mj_name2id(&m, mjOBJ_BODY, "distractor_1_0")];
  EXPECT_DOUBLE_EQ(box_half[0], 0.05);
  EXPECT_DOUBLE_EQ(box_half[1], 0.10);
  EXPECT_DOUBLE_EQ(box_half[2], 0.15);
  EXPECT_DOUBLE_EQ(tin_half[0], 0.035);
  EXPECT_DOUBLE_EQ(tin_half[1], 0.06);
}

TEST(Objects, APersonWalksOnTheFloorWithOneLegForward) {
  World world(world_with({{"walker", walker()}}), "", 1);
  const auto foot_m = [&world](const char* leg) {
    const mjModel& m = world.model();
    const int body = mj_name2id(&m, mjOBJ_BODY, leg);
    const int geom = m.body_geomadr[body];
    using Rotation = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
    const Eigen::Map<const Eigen::Vector3d> middle(world.data().geom_xpos + 3 * geom);
    const Eigen::Map<const Rotation> axes(world.data().geom_xmat + 9 * geom);
    const double down = axes(2, 2) < 0.0 ? 1.0 : -1.0;
    Eigen::Vector3d foot = middle + down * m.geom_size[3 * geom + 1] * axes.col(2);
    foot.z() -= m.geom_size[3 * geom];
    return foot;
  };
  double widest_m = 0.0;
  for (int tick = 0; tick < 2000; ++tick) {
    world.step();
    const Eigen::Vector3d trunk = body_m(world, world.data(), "distractor_0_0");
    const Eigen::Vector3d left = foot_m("distractor_0_1");
    const Eigen::Vector3d right = foot_m("distractor_0_3");
    for (const Eigen::Vector3d& foot : {left, right}) {
      ASSERT_GT(foot.z(), floor_m - 0.01);
      ASSERT_LT(foot.z(), floor_m + 0.08);
    }
    // Along y: one leg is as far in front of the trunk as the other one is behind it.
    ASSERT_NEAR(left.y() + right.y(), 2.0 * trunk.y(), 1e-6);
    widest_m = std::max(widest_m, std::abs(left.y() - right.y()));
  }
  EXPECT_GT(widest_m, 0.5);
  EXPECT_LT(widest_m, 0.9);
}

TEST(Objects, ACoveredDiscShowsItsShareOfTheOutline) {
  ObjectConfig disc;
  disc.shape = ObjectShape::covered_disc;
  disc.size_m = {0.01, 0.2, 0.2};
  disc.shown_share = 0.4;
  disc.trajectory.sway_m = 0.0;
  const World world(world_with({{"disc", disc}}), "", 1);
  const mjModel& m = world.model();
  const int body = mj_name2id(&m, mjOBJ_BODY, "distractor_0_0");
  ASSERT_EQ(m.body_geomnum[body], 2);
  const int cover = m.body_geomadr[body] + 1;
  const double top_m = m.geom_pos[3 * cover + 2] + m.geom_size[3 * cover + 2];
  int shown = 0;
  for (int i = 0; i < 1000; ++i) {
    if (0.1 * std::cos(2.0 * std::numbers::pi * i / 1000) > top_m) ++shown;
  }
  EXPECT_NEAR(shown / 1000.0, disc.shown_share, 0.002);
  EXPECT_LT(m.geom_pos[3 * cover + 2] - m.geom_size[3 * cover + 2], -0.1);  // it covers the rest
}

TEST(Objects, AHandWavesAndABoxTurns) {
  ObjectConfig hand;
  hand.shape = ObjectShape::hand;
  hand.trajectory.sway_m = 0.0;
  ObjectConfig box;
  box.turn_deg_s = {90.0, 0.0, 0.0};
  box.trajectory.sway_m = 0.0;
  World world(world_with({{"hand", hand}, {"box", box}}), "", 1);
  const auto up = [&](const char* name) {
    const int body = mj_name2id(&world.model(), mjOBJ_BODY, name);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(world.data().xmat + 9 * body);
    return Eigen::Vector3d(axes.col(2));
  };
  double most_rad = 0.0;
  for (int i = 0; i < 1000; ++i) {
    world.step();
    most_rad = std::max(most_rad, std::acos(std::clamp(up("distractor_0_0").z(), -1.0, 1.0)));
  }
  EXPECT_NEAR(most_rad, 0.45, 0.01);
  EXPECT_NEAR(up("distractor_1_0").y(), -1.0, 1e-6);  // a quarter turn about x
}

TEST(Objects, AddToTheMotionInTheImage) {
  NamedObjects objects = {{"tin", tin()}};
  objects[0].second.trajectory.kind = TrajectoryKind::waypoints;
  objects[0].second.trajectory.points_m = {{-0.5564, -0.034, 0.347}, {-0.5564, 0.5, 0.347}};
  objects[0].second.trajectory.profile = SpeedProfile::constant_speed;
  objects[0].second.trajectory.ramp_s = 0.01;
  objects[0].second.trajectory.speed_m_s = 0.5;
  objects[0].second.trajectory.sway_m = 0.0;
  World world(world_with(objects), "", 1);
  Camera camera = icub_left_2016;
  ImageMotion motion(world.model(), world.left_eye_camera(), camera);
  motion.start_from(world.data());
  for (int tick = 0; tick < 50; ++tick) world.step();
  // 25 mm minus 2.5 mm for half a ramp, at a distance of 0.5 m, and slightly less at its front.
  const double seen_px = motion.displacement_px(world.data());
  EXPECT_GT(seen_px, camera.fx_px * 0.0225 / 0.5);
  EXPECT_LT(seen_px, 1.2 * camera.fx_px * 0.0225 / 0.5);
}

TEST(Objects, AreReportedByNameWhenOutOfRange) {
  NamedObjects objects = {{"tin", tin()}};
  objects[0].second.size_m = {0.07, 0.07, 5.0};
  try {
    const World world(world_with(objects), "", 1);
    FAIL() << "took a tin of 5 m";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("world.objects.tin.size_m"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace saccade
