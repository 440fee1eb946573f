// The parts that a lab is drawn with, and the coupling of a head's motors.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/random.h"
#include "head/head_state.h"
#include "sim/canvas.h"
#include "sim/head_mjcf.h"
#include "sim/lab_layout.h"
#include "sim/random_generator.h"
#include "sim/value_noise.h"

namespace saccade {
namespace {

TEST(RandomGenerator, ItsSequenceDependsOnSeedAndNameAlone) {
  RandomGenerator a(1, "a"), same(1, "a"), seed(2, "a"), name(1, "b");
  bool other_seed = false, other_name = false;
  for (int i = 0; i < 20; ++i) {
    const double value = a.real(-1.0, 1.0);
    EXPECT_EQ(value, same.real(-1.0, 1.0));
    EXPECT_TRUE(value >= -1.0 && value < 1.0);
    other_seed |= value != seed.real(-1.0, 1.0);
    other_name |= value != name.real(-1.0, 1.0);
  }
  EXPECT_TRUE(other_seed && other_name);
}

TEST(RandomGenerator, DrawsIndicesChancesAndNormals) {
  RandomGenerator random(1, "draws");
  std::set<int> indices;
  int chances = 0;
  double sum = 0.0, squares = 0.0;
  constexpr int draws = 4000;
  for (int i = 0; i < draws; ++i) {
    indices.insert(random.index(5));
    chances += random.chance(0.25) ? 1 : 0;
    const double normal = random.normal();
    sum += normal;
    squares += normal * normal;
  }
  EXPECT_EQ(indices, (std::set<int>{0, 1, 2, 3, 4}));
  EXPECT_NEAR(chances, 0.25 * draws, 4.0 * std::sqrt(0.25 * 0.75 * draws));  // four deviations
  EXPECT_NEAR(sum / draws, 0.0, 4.0 / std::sqrt(draws));
  EXPECT_NEAR(squares / draws, 1.0, 4.0 * std::sqrt(2.0 / draws));
}

TEST(ValueNoise, IsSmoothBoundedAndRepeats) {
  RandomGenerator random(3, "noise");
  const ValueNoise noise(random);
  double least = 1.0, most = -1.0;
  for (int i = 0; i < 5000; ++i) {
    const double x = 0.037 * i, y = 0.011 * i;
    const double value = noise.at(x, y);
    least = std::min(least, value);
    most = std::max(most, value);
    EXPECT_NEAR(noise.at(x + 64.0, y - 64.0), value, 1e-9);
    EXPECT_NEAR(noise.at(x + 1e-4, y), value, 1e-3) << "smooth";
    EXPECT_LE(std::abs(noise.sum(x, y, 4)), 3.0);
  }
  EXPECT_GE(least, -1.0);
  EXPECT_LE(most, 1.0);
  EXPECT_GT(most - least, 1.0);
}

TEST(Canvas, PaintsShapesInMetres) {
  Canvas canvas(0.2, 0.1, 200, 100);
  canvas.fill(grey(1.0));
  canvas.rectangle(0.05, 0.02, 0.1, 0.05, grey(0.0));
  double dark = 0.0;
  canvas.each([&](double, double, Reflectance old) {
    dark += 1.0 - old.g;
    return old;
  });
  EXPECT_NEAR(dark, 100.0 * 50.0, 1.0) << "texels of 1 mm";
  EXPECT_EQ(canvas.texel(100, 40).r, 0.0);
  EXPECT_EQ(canvas.texel(10, 40).r, 1.0);
}

TEST(Layout, PacksPatchesWithoutOverlap) {
  lab::Layout layout(-1.5);
  RandomGenerator random(1, "layout");
  const auto paint = [](Canvas&, RandomGenerator&) {};
  for (int i = 0; i < 40; ++i) layout.add_patch(random.real(0.05, 0.6), random.real(0.05, 0.6), 300.0, paint);
  EXPECT_EQ(layout.texture_rows(), 0);
  layout.pack();
  const auto& patches = layout.patches();
  ASSERT_EQ(patches.size(), 40U);
  for (std::size_t a = 0; a < patches.size(); ++a) {
    EXPECT_GE(patches[a].left, 0);
    EXPECT_LE(patches[a].left + patches[a].columns, lab::Layout::texture_columns);
    EXPECT_LE(patches[a].top + patches[a].rows, layout.texture_rows());
    for (std::size_t b = 0; b < a; ++b) {
      const bool apart = patches[a].left >= patches[b].left + patches[b].columns ||
                         patches[b].left >= patches[a].left + patches[a].columns ||
                         patches[a].top >= patches[b].top + patches[b].rows ||
                         patches[b].top >= patches[a].top + patches[a].rows;
      EXPECT_TRUE(apart) << a << " and " << b;
    }
  }
}

TEST(Layout, ASolidHasSixFacesThatLookOutwards) {
  lab::Layout layout(-1.5);
  const std::size_t patch = layout.add_patch(0.1, 0.1, 100.0, [](Canvas&, RandomGenerator&) {});
  const Eigen::Vector3d centre(-1.0, 0.2, 0.3);
  layout.add_solid(centre, {0.1, 0.2, 0.05}, patch);
  ASSERT_EQ(layout.triangles().size(), 12U);
  for (const lab::Triangle& triangle : layout.triangles()) {
    const Eigen::Vector3d a = triangle.corners[0].point_m, b = triangle.corners[1].point_m,
                          c = triangle.corners[2].point_m;
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    EXPECT_GT(normal.dot((a + b + c) / 3.0 - centre), 0.0);
    EXPECT_GT(normal.dot(triangle.corners[0].normal), 0.99);
  }
}

TEST(Layout, AxesOfAFacingAreARotation) {
  using lab::Facing;
  for (const Facing facing : {Facing::back_wall, Facing::left_wall, Facing::right_wall, Facing::rear_wall,
                              Facing::up, Facing::down}) {
    const Eigen::Matrix3d axes = lab::axes_of(facing);
    EXPECT_TRUE((axes.transpose() * axes).isIdentity(1e-12));
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);
  }
}

TEST(MotorCoupling, JointsAndMotorsAreInverses) {
  const std::shared_ptr<const HeadModel> head = default_head();
  const MotorCoupling coupling(*head);
  const RandomStream random(1, "coupling");
  JointVector joints = JointVector::Zero();
  for (const HeadJoint& joint : head->joints)
    joints[joint.slot] = random.uniform(-0.5, 0.5, 0, static_cast<std::uint64_t>(joint.slot));
  EXPECT_LT((coupling.joints_from_motors(coupling.motors_from_joints(joints)) - joints).norm(), 1e-12);
}

TEST(MjcfNumbers, ReadBackTheSame) {
  EXPECT_EQ(mjcf_numbers(0.5), "0.5");
  EXPECT_EQ(mjcf_numbers(Eigen::Vector3d(1, -2.25, 1e-3)), "1 -2.25 0.001");
}

}  // namespace
}  // namespace saccade
