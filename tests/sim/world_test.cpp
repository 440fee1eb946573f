#include "sim/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <limits>
#include <numbers>

#include "core/camera.h"
#include "core/random.h"
#include "core/units.h"
#include "head/head_model.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

constexpr double deg = rad_per_deg;

WorldConfig still_world() {
  WorldConfig config;
  config.ball.trajectory.sway_m = 0.0;
  return config;
}

HeadJointVector head(const JointVector& joints) { return joints.tail<gaze_slots>(); }

double largest_deg(const JointVector& rad) { return rad.cwiseAbs().maxCoeff() / deg; }

/// Largest distance of a joint outside its limits, rad; negative inside.
double outside(const JointVector& q, const JointLimits& limits) {
  return std::max((q - limits.max_rad).maxCoeff(), (limits.min_rad - q).maxCoeff());
}

TEST(World, HasTheLimitsOfTheRobot) {
  const World world(still_world(), "", 1);
  JointVector min_deg = JointVector::Zero(), max_deg = JointVector::Zero();
  min_deg << -20, -30, -50, -30, -20, -45, -30, -30, 0;
  max_deg << 70, 30, 50, 17, 20, 45, 30, 30, 50;
  EXPECT_LT(largest_deg(world.limits().min_rad - min_deg * deg), 1e-9);
  EXPECT_LT(largest_deg(world.limits().max_rad - max_deg * deg), 1e-9);
  for (const HeadJoint& joint : world.limits().head->joints)
    EXPECT_GT(world.limits().max_speed_rad_s[joint.slot], 0.0) << joint.name;
}

TEST(World, HasTheMassOfTheRobot) {
  const World world(still_world(), "", 1);
  const mjModel& m = world.model();
  const auto mass = [&m](const char* body) { return m.body_subtreemass[mj_name2id(&m, mjOBJ_BODY, body)]; };
  EXPECT_NEAR(mass("head"), 1.50691, 1e-6);
  EXPECT_NEAR(mass("torso_1"), 10.544915, 1e-6);
}

TEST(World, StartsAtRestWithLittleSag) {
  World world(still_world(), "", 1);
  const JointVector start = world.head_state().position_rad;
  EXPECT_LT(largest_deg(start), 0.3);
  EXPECT_LT(largest_deg(world.head_state().velocity_rad_s), 1e-3);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_EQ(world.now_us(), 1'000'000);
  EXPECT_LT(largest_deg(world.head_state().position_rad - start), 1e-4);
}

TEST(World, SagsLittleInAnyPose) {
  const RandomStream random(3, "test/sag");
  double worst_deg = 0.0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    WorldConfig config = still_world();
    World probe(config, "", 1);
    for (std::size_t j = 0; j < joint_count; ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      config.initial_pose_deg[j] =
          random.uniform(probe.limits().min_rad[row] / deg, probe.limits().max_rad[row] / deg, i, j);
    }
    const World world(config, "", 1);
    const JointVector pose = Eigen::Map<const JointVector>(config.initial_pose_deg.data()) * deg;
    worst_deg = std::max(worst_deg, largest_deg(world.head_state().position_rad - pose));
    EXPECT_LT(largest_deg(world.head_state().velocity_rad_s), 0.01);
  }
  RecordProperty("worst_sag_deg", std::to_string(worst_deg));
  std::cout << "worst sag " << worst_deg << " deg\n";
  EXPECT_LT(worst_deg, 0.3);
}

struct StepResponse {
  double to_63_s = 0.0;
  double overshoot = 0.0;  // share of the step
  double cross_deg = 0.0;  // largest movement of the other joints
};

StepResponse step_response(int joint, double size_rad) {
  WorldConfig config = still_world();
  config.initial_pose_deg[eyes_vergence] = 10.0;
  World world(config, "", 1);
  for (int i = 0; i < 200; ++i) world.step();
  const JointVector start = world.head_state().position_rad;
  HeadJointVector reference = HeadJointVector::Zero();
  reference[eyes_vergence - torso_joint_count] = 10.0 * deg;
  reference[joint - torso_joint_count] += size_rad;
  EXPECT_TRUE(world.set_reference(reference));
  std::vector<double> response;
  StepResponse result;
  for (int i = 0; i < 1000; ++i) {
    world.step();
    JointVector moved = world.head_state().position_rad - start;
    response.push_back(moved[joint]);
    moved[joint] = 0.0;
    result.cross_deg = std::max(result.cross_deg, largest_deg(moved));
  }
  const double last = response.back();
  const auto reached =
      std::find_if(response.begin(), response.end(), [last](double q) { return q / last >= 0.6321; });
  result.to_63_s = 1e-3 * static_cast<double>(reached - response.begin() + 1);
  for (const double q : response) result.overshoot = std::max(result.overshoot, q / last - 1.0);
  EXPECT_NEAR(last, size_rad, 0.02 * std::abs(size_rad)) << joint_names[static_cast<std::size_t>(joint)];
  return result;
}

/// A critically damped servo of natural frequency w reaches 63 % after 2.146 / w and passes -3 dB at
/// 0.644 w: for 8 to 12 Hz that is 18 to 28 ms, for 25 to 30 Hz 7.3 to 8.8 ms (and up to a tick more).
class ServoStep : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(EveryHeadJoint, ServoStep,
                         testing::Range(static_cast<int>(neck_pitch), static_cast<int>(joint_count)),
                         [](const auto& test) {
                           return std::string(joint_names[static_cast<std::size_t>(test.param)]);
                         });

TEST_P(ServoStep, ReachesItsTargetInTimeWithoutOvershoot) {
  const bool eye = GetParam() >= eyes_tilt;
  for (const double size_rad : {1.0 * deg, 4.0 * deg, -4.0 * deg}) {
    const StepResponse response = step_response(GetParam(), size_rad);
    std::cout << size_rad / deg << " deg: 63 % after " << 1e3 * response.to_63_s << " ms, overshoot "
              << 100.0 * response.overshoot << " %, others move " << response.cross_deg << " deg\n";
    EXPECT_LT(response.overshoot, 0.005);
    if (size_rad != 1.0 * deg) continue;  // larger steps meet the force limit
    EXPECT_GE(response.to_63_s, eye ? 0.007 : 0.018);
    EXPECT_LE(response.to_63_s, eye ? 0.010 : 0.028);
    EXPECT_LT(response.cross_deg, 0.1);
  }
}

TEST_P(ServoStep, FollowsARampAtItsLargestSpeed) {
  WorldConfig config = still_world();
  config.initial_pose_deg[eyes_vergence] = 10.0;
  World world(config, "", 1);
  const int joint = GetParam();
  const double speed = world.limits().max_speed_rad_s[joint];
  const double start = world.head_state().position_rad[joint];
  const double distance = 0.95 * world.limits().max_rad[joint] - start;
  HeadJointVector reference = head(world.head_state().position_rad);
  double lag_s = 0.0;
  double travelled = 0.0;
  for (int tick = 1; travelled < distance; ++tick) {
    travelled = speed * 1e-3 * tick;
    reference[joint - torso_joint_count] = start + std::min(travelled, distance);
    ASSERT_TRUE(world.set_reference(reference));
    world.step();
    lag_s = std::max(lag_s, (start + travelled - world.head_state().position_rad[joint]) / speed);
  }
  // The ramp lag of a critically damped servo is 2 / w: 21 to 32 ms for the neck, 8 to 10 ms for the eyes.
  std::cout << "lag at " << speed / deg << " deg/s: " << 1e3 * lag_s << " ms\n";
  EXPECT_LT(lag_s, joint >= eyes_tilt ? 0.012 : 0.034);
}

TEST(World, StaysInsideItsLimitsAgainstGravity) {
  const JointLimits limits = World(still_world(), "", 1).limits();
  double worst = -1.0;
  for (int corner = 0; corner < 64; ++corner) {
    WorldConfig config = still_world();
    config.initial_pose_deg[torso_pitch] = (corner % 3 - 1) * 20.0;  // lean back and forward as well
    config.initial_pose_deg[torso_roll] = (corner % 2) * 30.0;
    World world(config, "", 1);
    HeadJointVector reference = HeadJointVector::Zero();
    for (int j = 0; j < head_joint_count; ++j) {
      const int joint = torso_joint_count + j;
      reference[j] = (corner >> j) % 2 == 0 ? limits.min_rad[joint] : limits.max_rad[joint];
    }
    ASSERT_TRUE(world.set_reference(reference));  // immediately at the start: the worst case
    for (int i = 0; i < 1500; ++i) {
      world.step();
      worst = std::max(worst, outside(world.head_state().position_rad, limits));
    }
    const HeadJointVector error = reference - head(world.head_state().position_rad);
    EXPECT_LT(error.cwiseAbs().maxCoeff() / deg, 0.3);
  }
  std::cout << "worst excess " << worst / deg << " deg\n";
  EXPECT_LT(worst / deg, 0.01);
}

TEST(World, RejectsReferencesOutsideItsLimitsAndKeepsTheLastOne) {
  World world(still_world(), "", 1);
  HeadJointVector good = HeadJointVector::Zero();
  good[0] = 0.1;
  ASSERT_TRUE(world.set_reference(good));
  for (const double bad :
       {0.5, std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    HeadJointVector reference = HeadJointVector::Zero();
    reference[0] = bad;
    EXPECT_FALSE(world.set_reference(reference));
  }
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR(world.head_state().position_rad[neck_pitch], 0.1, 0.3 * deg);
}

TEST(World, CouplesTheEyesIntoVersionAndVergence) {
  World world(still_world(), "", 1);
  HeadJointVector reference = HeadJointVector::Zero();
  reference[4] = 12.0 * deg;
  reference[5] = 20.0 * deg;
  ASSERT_TRUE(world.set_reference(reference));
  for (int i = 0; i < 500; ++i) world.step();
  const auto yaw_deg = [](const Eigen::Isometry3d& pose) {
    const Eigen::Vector3d axis = pose.linear().col(2);
    return std::atan2(axis.y(), -axis.x()) / deg;  // to the right, seen from the robot
  };
  EXPECT_NEAR(yaw_deg(world.root_from_left_cam()), 22.0, 0.1);
  EXPECT_NEAR(yaw_deg(world.root_from_right_cam()), 2.0, 0.1);
  EXPECT_NEAR(world.head_state().position_rad[eyes_version] / deg, 12.0, 0.1);
  EXPECT_NEAR(world.head_state().position_rad[eyes_vergence] / deg, 20.0, 0.1);
}

TEST(World, ReportsVelocitiesThatMatchItsPositions) {
  World world(still_world(), "", 1);
  HeadJointVector reference = HeadJointVector::Zero();
  reference.head<head_joint_count>() << 0.1, -0.1, 0.3, 0.2, -0.2, 0.3;
  ASSERT_TRUE(world.set_reference(reference));
  HeadState last = world.head_state();
  for (int i = 0; i < 300; ++i) {
    world.step();
    const HeadState now = world.head_state();
    EXPECT_EQ(now.t_us, last.t_us + 1000);
    ASSERT_LT(((now.position_rad - last.position_rad) / 1e-3 - now.velocity_rad_s).cwiseAbs().maxCoeff(),
              1e-9);
    last = now;
  }
}

TEST(World, MovesTheBallAlongItsTrajectory) {
  WorldConfig config;
  config.ball.trajectory.kind = TrajectoryKind::circle;
  config.ball.trajectory.start_s = 0.1;
  World world(config, "", 5);
  const Trajectory trajectory(config.ball.trajectory, 5);
  const int ball = mj_name2id(&world.model(), mjOBJ_GEOM, "ball");
  for (int i = 0; i < 1000; ++i) {
    world.step();
    const Eigen::Vector3d drawn = Eigen::Map<const Eigen::Vector3d>(world.data().geom_xpos + 3 * ball);
    ASSERT_LT((drawn - trajectory.position_m(world.now_us())).norm(), 1e-12);
    ASSERT_EQ(world.target_position_m(), trajectory.position_m(world.now_us()));
  }
  EXPECT_EQ(world.first_motion_us(), 100'000);
}

TEST(World, InterpolatesBetweenTicks) {
  WorldConfig config;
  config.ball.trajectory.kind = TrajectoryKind::circle;
  World world(config, "", 5);
  HeadJointVector reference = HeadJointVector::Zero();
  reference.head<head_joint_count>() << 0.1, -0.1, 0.3, 0.2, -0.2, 0.3;
  ASSERT_TRUE(world.set_reference(reference));
  const MjDataPtr between(mj_makeData(&world.model()));
  const Trajectory trajectory(config.ball.trajectory, 5);
  const int ball = mj_name2id(&world.model(), mjOBJ_GEOM, "ball");
  for (int i = 0; i < 50; ++i) {
    const Eigen::Isometry3d before = world.root_from_left_cam();
    world.step();
    const Eigen::Isometry3d after = world.root_from_left_cam();
    world.show(world.now_us(), *between);
    EXPECT_TRUE(World::root_from_camera(*between, world.left_eye_camera()).isApprox(after, 1e-14));
    world.show(world.now_us() - 999, *between);
    EXPECT_TRUE(World::root_from_camera(*between, world.left_eye_camera()).isApprox(before, 2e-5));
    world.show(world.now_us() - 400, *between);
    const double turned = Eigen::AngleAxisd(before.linear().transpose() * after.linear()).angle();
    const Eigen::Isometry3d middle = World::root_from_camera(*between, world.left_eye_camera());
    EXPECT_NEAR(Eigen::AngleAxisd(before.linear().transpose() * middle.linear()).angle(), 0.6 * turned,
                0.1 * turned + 1e-6);
    const Eigen::Vector3d drawn = Eigen::Map<const Eigen::Vector3d>(between->geom_xpos + 3 * ball);
    EXPECT_LT((drawn - trajectory.position_m(world.now_us() - 400)).norm(), 1e-12);
  }
}

TEST(World, IsTheSameForTheSameSeed) {
  WorldConfig config;
  config.ball.trajectory.kind = TrajectoryKind::circle;
  World a(config, "", 9);
  World b(config, "", 9);
  HeadJointVector reference = HeadJointVector::Constant(0.05);
  for (int i = 0; i < 500; ++i) {
    if (i == 100) {
      a.set_reference(reference);
      b.set_reference(reference);
    }
    a.step();
    b.step();
  }
  EXPECT_EQ(
      std::memcmp(a.data().qpos, b.data().qpos, sizeof(mjtNum) * static_cast<std::size_t>(a.model().nq)), 0);
  EXPECT_EQ(a.target_position_m(), b.target_position_m());
  EXPECT_NE(a.target_position_m(), World(config, "", 10).target_position_m());
}

World world_with_ball(double diameter_m, const Eigen::Vector3d& ball_m) {
  WorldConfig config = still_world();
  config.ball.diameter_m = diameter_m;
  config.ball.trajectory.points_m = {ball_m};
  return World(config, "", 1);
}

/// Share of the ball's disc, seen from a point, that hand and arm cover; by rays.
double covered_share(World& world, const Eigen::Vector3d& from_m) {
  const int ball = mj_name2id(&world.model(), mjOBJ_GEOM, "ball");
  const mjtByte groups[mjNGROUP] = {1, 1, 0, 0, 0, 0};  // groups that an eye draws
  const Eigen::Vector3d forward = world.target_position_m() - from_m;
  const Eigen::Vector3d side = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d up = side.cross(forward).normalized();
  // The cone that touches the ball, cut with the plane through its centre.
  const double sine = *world.target_radius_m() / forward.norm();
  const double disc_m = *world.target_radius_m() / std::sqrt(1.0 - sine * sine);
  int rays = 0;
  int free = 0;
  for (double v = -0.98; v <= 0.98; v += 0.04) {
    for (double u = -0.98; u <= 0.98; u += 0.04) {
      if (std::hypot(u, v) > 0.98) continue;
      const Eigen::Vector3d ray = forward + disc_m * (u * side + v * up);
      const int hit = first_geom_on_ray(&world.model(), &world.data(), from_m.data(), ray.data(), groups);
      ++rays;
      free += hit == ball;
    }
  }
  return 1.0 - static_cast<double>(free) / rays;
}

TEST(BallInHand, IsHardlyHiddenByTheHandInTheRobotsView) {
  double worst = 0.0;
  for (const double diameter_m : {0.065, 0.095, 0.12}) {
    for (const double x : {-0.506, -0.356}) {
      for (const double y : {-0.15, 0.0, 0.15}) {
        for (const double z : {0.25, 0.347, 0.45}) {
          World world = world_with_ball(diameter_m, {x, y, z});
          worst = std::max({worst, covered_share(world, world.root_from_left_cam().translation()),
                            covered_share(world, world.root_from_right_cam().translation())});
        }
      }
    }
  }
  std::cout << "covered at most: " << worst << "\n";
  EXPECT_LT(worst, 0.15);
}

TEST(BallInHand, IsHeldBetweenThePersonAndTheBall) {
  World world = world_with_ball(0.095, {-0.506, 0.0, 0.347});
  EXPECT_GT(covered_share(world, world.target_position_m() + Eigen::Vector3d(-0.6, -0.05, 0.0)), 0.5);
}

TEST(BallInHand, HasAPlainOrACheckedSleeve) {
  const auto sleeve_texture = [](Sleeve sleeve) {
    WorldConfig config = still_world();
    config.ball.sleeve = sleeve;
    World world(config, "", 1);
    const mjModel& m = world.model();
    const int material = m.geom_matid[mj_name2id(&m, mjOBJ_GEOM, "arm_sleeve")];
    return std::string(mj_id2name(&m, mjOBJ_MATERIAL, material));
  };
  EXPECT_EQ(sleeve_texture(Sleeve::plain), "person_sleeve");
  EXPECT_EQ(sleeve_texture(Sleeve::checked), "person_sleeve_checked");
}

TEST(BallInHand, TouchesTheBallWithEveryFingertip) {
  for (const double diameter_m : {0.065, 0.095, 0.12}) {
    WorldConfig config = still_world();
    config.ball.diameter_m = diameter_m;
    World world(config, "", 1);
    const mjModel& m = world.model();
    for (const char* finger :
         {"hand_index_2", "hand_middle_2", "hand_ring_2", "hand_little_2", "hand_thumb_2"}) {
      const int g = mj_name2id(&m, mjOBJ_GEOM, finger);
      const Eigen::Vector3d tip =
          Eigen::Map<const Eigen::Vector3d>(world.data().geom_xpos + 3 * g) +
          m.geom_size[3 * g + 1] *
              Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(world.data().geom_xmat + 9 * g)
                  .col(2);
      const double gap_m =
          (tip - world.target_position_m()).norm() - *world.target_radius_m() - m.geom_size[3 * g];
      EXPECT_NEAR(gap_m, 0.0, 0.007) << finger << " " << diameter_m;
    }
  }
}

TEST(World, AddsTheLabToTheModel) {
  const std::string lab =
      "<asset><texture name='t' type='2d' builtin='flat' rgb1='.5 .5 .5' width='8' height='8'/></asset>"
      "<worldbody><geom name='wall' type='box' size='.1 2 2' pos='-2 0 0' contype='0' "
      "conaffinity='0'/></worldbody>";
  World world(still_world(), lab, 1);
  EXPECT_GE(mj_name2id(&world.model(), mjOBJ_GEOM, "wall"), 0);
  EXPECT_THROW(World(still_world(), "<worldbody><geom type='sausage'/></worldbody>", 1), RunError);
}

/// Its texture has a texel per half millimetre: OpenGL draws none above 16,384 texels.
TEST(World, RejectsABoardLargerThanFourMetres) {
  WorldConfig config = still_world();
  config.board.emplace();
  config.board->spacing_mm = 200.0;
  config.board->columns = 20;
  config.board->rows = 21;
  EXPECT_THROW(World(config, "", 1), InputError);
}

TEST(World, ClassifiesGeomsByTheirNames) {
  World world(still_world(),
              "<worldbody><geom name='wall' size='.1'/><geom name='distractor_1' size='.1'/>"
              "<body name='distractor'><geom name='object' size='.1'/></body></worldbody>",
              1);
  const std::vector<std::uint8_t> objects = world.scene_objects();
  const auto object_of = [&](const char* name) {
    const int geom = mj_name2id(&world.model(), mjOBJ_GEOM, name);
    return static_cast<SceneObject>(objects.at(static_cast<std::size_t>(geom)));
  };
  EXPECT_EQ(object_of("ball"), SceneObject::ball);
  EXPECT_EQ(object_of("hand_palm"), SceneObject::hand);
  EXPECT_EQ(object_of("arm_sleeve"), SceneObject::arm);
  EXPECT_EQ(object_of("distractor_1"), SceneObject::distractor);
  EXPECT_EQ(object_of("object"), SceneObject::distractor);
  EXPECT_EQ(object_of("wall"), SceneObject::background);
}

TEST(World, ReportsAMissingModelFile) {
  try {
    const World world(still_world(), "", 1, "/nowhere/models");
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("/nowhere/models/icub_head.xml"));
  }
}

TEST(World, RejectsAStartOutsideTheLimits) {
  WorldConfig config = still_world();
  config.initial_pose_deg[neck_pitch] = 20.0;
  config.initial_pose_deg[eyes_vergence] = -1.0;
  try {
    const World world(config, "", 1);
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 2u);
    EXPECT_THAT(error.what(), testing::HasSubstr("neck_pitch 20"));
  }
  config.initial_pose_deg[neck_pitch] = 17.0;
  config.initial_pose_deg[eyes_vergence] = 50.0;
  EXPECT_NO_THROW(World(config, "", 1));
}

TEST(World, ThrowsAnErrorWhenTheSimulationDiverges) {
  World world(still_world(), "", 1);
  world.data().qvel[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(world.step(), RunError);
}

}  // namespace
}  // namespace saccade
