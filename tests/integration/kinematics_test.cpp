#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <numbers>
#include <tuple>

#include "control/head_kinematics.h"
#include "core/random.h"
#include "head/head_model.h"
#include "sim/world.h"
#include "tests/control/described_head.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

Eigen::Isometry3d root_from_left_cam(const JointVector& q) {
  return HeadKinematics(default_head()->chain, q).root_from_eye(Eye::left);
}
Eigen::Isometry3d root_from_right_cam(const JointVector& q) {
  return HeadKinematics(default_head()->chain, q).root_from_eye(Eye::right);
}

constexpr int poses = 1000;

struct PoseError {
  double position_m = 0.0;
  double angle_rad = 0.0;

  void add(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    position_m = std::max(position_m, (a.translation() - b.translation()).norm());
    // The angle of a small rotation from its sine: acos of the trace is inaccurate below 1e-8.
    const Eigen::Matrix3d r = a.linear().transpose() * b.linear();
    const Eigen::Vector3d twice_sine(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
    angle_rad = std::max(angle_rad, std::atan2(twice_sine.norm(), r.trace() - 1.0));
  }
};

JointVector random_pose(const JointLimits& limits, std::uint64_t i) {
  const RandomStream random(11, "test/kinematics");
  JointVector q = JointVector::Zero();
  for (int j = 0; j < joint_count; ++j) {
    q[j] = random.uniform(limits.min_rad[j], limits.max_rad[j], i, static_cast<std::uint64_t>(j));
  }
  return q;
}

/// The plant with its joints at `q`, without a step.
class PosedPlant {
 public:
  explicit PosedPlant(const WorldConfig& config = {})
      : world_(config, "", 1), data_(mj_makeData(&world_.model())) {}

  void pose(const JointVector& q) {
    for (int j = 0; j < eyes_version; ++j) set(std::string(joint_names[static_cast<std::size_t>(j)]), q[j]);
    set("l_eye_pan", q[eyes_version] + 0.5 * q[eyes_vergence]);
    set("r_eye_pan", q[eyes_version] - 0.5 * q[eyes_vergence]);
    mj_kinematics(&world_.model(), data_.get());
    mj_comPos(&world_.model(), data_.get());
    mj_camlight(&world_.model(), data_.get());
  }
  [[nodiscard]] Eigen::Isometry3d left() const {
    return World::root_from_camera(*data_, world_.left_eye_camera());
  }
  [[nodiscard]] Eigen::Isometry3d right() const {
    return World::root_from_camera(*data_, world_.right_eye_camera());
  }
  [[nodiscard]] const JointLimits& limits() const { return world_.limits(); }
  [[nodiscard]] World& world() { return world_; }

 private:
  void set(const std::string& joint, double q) {
    const mjModel& m = world_.model();
    data_->qpos[m.jnt_qposadr[mj_name2id(&m, mjOBJ_JOINT, joint.c_str())]] = q;
  }

  World world_;
  MjDataPtr data_;
};

/// iKin's v2 eye chain, computed from the rows of its table.
Eigen::Isometry3d dh_chain(const JointVector& q, bool left) {
  constexpr double half_pi = std::numbers::pi / 2.0;
  struct Row {
    double a, d, alpha, offset;
  };
  const std::array<Row, 8> rows = {{{0.032, 0.0, half_pi, 0.0},
                                    {0.0, -0.0055, half_pi, -half_pi},
                                    {0.0, -0.2233, -half_pi, -half_pi},
                                    {0.0095, 0.0, half_pi, half_pi},
                                    {0.0, 0.0, -half_pi, -half_pi},
                                    {-0.0509, 0.08205, -half_pi, half_pi},
                                    {0.0, left ? -0.034 : 0.034, -half_pi, 0.0},
                                    {0.0, 0.0, half_pi, -half_pi}}};
  const double pan = q[eyes_version] + (left ? 0.5 : -0.5) * q[eyes_vergence];
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double angle = (i == 7 ? pan : q[static_cast<Eigen::Index>(i)]) + rows[i].offset;
    t = t * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
        Eigen::Translation3d(rows[i].a, 0.0, rows[i].d) *
        Eigen::AngleAxisd(rows[i].alpha, Eigen::Vector3d::UnitX());
  }
  return t;
}

TEST(Kinematics, ThePlantHasTheDhChainOfTheRobot) {
  PosedPlant plant;
  PoseError error;
  for (std::uint64_t i = 0; i < poses; ++i) {
    const JointVector q = random_pose(plant.limits(), i);
    plant.pose(q);
    error.add(plant.left(), dh_chain(q, true));
    error.add(plant.right(), dh_chain(q, false));
  }
  std::cout << "plant against DH: " << error.position_m << " m, " << error.angle_rad << " rad\n";
  EXPECT_LT(error.position_m, 1e-9);
  EXPECT_LT(error.angle_rad, 1e-9);
}

TEST(Kinematics, TheControllersModelEqualsThePlant) {
  PosedPlant plant;
  PoseError error;
  for (std::uint64_t i = 0; i < poses; ++i) {
    const JointVector q = random_pose(plant.limits(), i);
    plant.pose(q);
    error.add(plant.left(), root_from_left_cam(q));
    error.add(plant.right(), root_from_right_cam(q));
  }
  std::cout << "controller against plant: " << error.position_m << " m, " << error.angle_rad << " rad\n";
  EXPECT_LT(error.position_m, 1e-9);
  EXPECT_LT(error.angle_rad, 1e-9);
}

/// The plant of a head against its description, over the whole range of the joints.
PoseError plant_against_description(const HeadConfig& head) {
  WorldConfig config;
  config.head = head;
  World world(config, "", 1);
  const HeadModel& model = *world.limits().head;
  const MjDataPtr data(mj_makeData(&world.model()));
  PoseError error;
  for (std::uint64_t i = 0; i < poses; ++i) {
    const RandomStream random(12, "test/heads");
    JointVector q = JointVector::Zero();
    for (const HeadJoint& joint : model.joints)
      q[joint.slot] = random.uniform(joint.min_rad, joint.max_rad, i, static_cast<std::uint64_t>(joint.slot));
    world.pose(0, q, *data);
    const HeadKinematics at(model.chain, q);
    error.add(World::root_from_camera(*data, world.left_eye_camera()), at.root_from_eye(Eye::left));
    if (model.chain.eyes > 1)
      error.add(World::root_from_camera(*data, world.right_eye_camera()), at.root_from_eye(Eye::right));
  }
  std::cout << model.name << ", plant against description: " << error.position_m << " m, " << error.angle_rad
            << " rad\n";
  return error;
}

TEST(Kinematics, ThePlantOfEachVersionOfTheIcubHasItsChain) {
  for (const std::string& version : icub_versions()) {
    HeadConfig head;
    head.version = version;
    const PoseError error = plant_against_description(head);
    EXPECT_LT(error.position_m, 1e-9) << version;
    EXPECT_LT(error.angle_rad, 1e-9) << version;
  }
}

TEST(Kinematics, ThePlantOfADescribedHeadHasItsChain) {
  for (const HeadDescription& description : {pan_tilt(), twelve_joints()}) {
    HeadConfig head;
    head.model = HeadKind::described;
    head.description = description;
    const PoseError error = plant_against_description(head);
    EXPECT_LT(error.position_m, 1e-9) << description.name;
    EXPECT_LT(error.angle_rad, 1e-9) << description.name;
  }
}

TEST(Kinematics, AModelWithAnotherChainIsAnInputError) {
  const TempFolder folder;
  HeadConfig head;
  head.model = HeadKind::described;
  head.description = pan_tilt();
  std::string mjcf = head_mjcf(*head_model(head), models_directory());
  head.description.mjcf = folder.write("mine.xml", mjcf).string();
  EXPECT_LT(plant_against_description(head).position_m, 1e-9);
  mjcf.replace(mjcf.find("0.045"), 5, "0.046");
  folder.write("mine.xml", mjcf);
  try {
    (void)plant_against_description(head);
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("camera left_eye 1 mm"), std::string::npos) << error.what();
  }
}

TEST(Kinematics, AModelThatMujocoRejectsIsAnInputErrorInOneLine) {
  const TempFolder folder;
  HeadConfig head;
  head.model = HeadKind::described;
  head.description = pan_tilt();
  const std::string mjcf = head_mjcf(*head_model(head), models_directory());
  std::string other_joint = mjcf;
  other_joint.replace(other_joint.find("<joint name=\"tilt\""), 18, "<joint name=\"tile\"");
  for (const std::string& text : {std::string("<mujoco><oops"), other_joint}) {
    head.description.mjcf = folder.write("mine.xml", text).string();
    try {
      (void)plant_against_description(head);
      FAIL() << "taken: " << text.substr(0, 40);
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(head.description.mjcf + ": found ")) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

/// iCubGenova02's URDF from the root to the left eye, joint by joint: origin in the parent's frame and axis in
/// its own. All frames but the root have the same orientation: x is the root's -y, y its z, z its -x.
Eigen::Vector3d urdf_left_eye_m(const JointVector& q) {
  struct UrdfJoint {
    Eigen::Vector3d origin_m, axis;
  };
  const std::array<UrdfJoint, 7> joints = {{{{0.0, 0.0, 0.0}, {1, 0, 0}},
                                            {{0.0269348, 0.032, -0.0573446}, {0, 0, -1}},
                                            {{0.0, 0.05, 0.0628421}, {0, -1, 0}},
                                            {{-0.0143, 0.172797, 0.0053118}, {-1, 0, 0}},
                                            {{0.0143, 0.0095, 0.02079997}, {0, 0, 1}},
                                            {{0.0, -0.022344, -0.02079997}, {0, 1, 0}},
                                            {{0.0, 0.104897, 0.0455907}, {-1, 0, 0}}}};
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t.linear() << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  t.translation() << 0.0, 0.0269348, 0.0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    t = t * Eigen::Translation3d(joints[i].origin_m) *
        Eigen::AngleAxisd(q[static_cast<Eigen::Index>(i)], joints[i].axis);
  }
  return t * Eigen::Vector3d(0.034, 0.0, 0.0);
}

TEST(Kinematics, ThePlantWithCadAxesEqualsTheUrdfOfTheRobot) {
  WorldConfig cad;
  cad.plant.axes = NeckAxes::cad;
  PosedPlant plant(cad);
  double worst_m = 0.0;
  for (std::uint64_t i = 0; i < poses; ++i) {
    JointVector q = random_pose(plant.limits(), i);
    if (i == 0) q.setZero();
    plant.pose(q);
    // Its torso is that of iKin, whose yaw axis differs by 2.5 um.
    worst_m = std::max(worst_m, (plant.left().translation() - urdf_left_eye_m(q)).norm());
  }
  std::cout << "plant with its axes of the CAD against the URDF: " << 1e3 * worst_m << " mm\n";
  EXPECT_LT(worst_m, 1e-5);
}

TEST(Kinematics, AHeadWithCadAxesMissesTheFixationPointByAboutAPixel) {
  WorldConfig config;
  config.plant.axes = NeckAxes::cad;
  PosedPlant plant(config);
  // Published comparisons of URDF and iKin: mean and largest bearing error at 0.30 and 0.45 m.
  for (const auto& [distance_m, mean_deg, largest_deg] :
       {std::tuple{0.30, 0.44, 0.97}, std::tuple{0.45, 0.29, 0.65}}) {
    double sum_deg = 0.0;
    double worst_deg = 0.0;
    for (std::uint64_t i = 0; i < poses; ++i) {
      JointVector q = random_pose(plant.limits(), i);
      q.head<torso_joint_count>().setZero();
      plant.pose(q);
      const Eigen::Vector3d target_m = root_from_left_cam(q) * Eigen::Vector3d(0.0, 0.0, distance_m);
      const Eigen::Vector3d in_cam_m = plant.left().inverse() * target_m;
      const double error_deg = std::atan2(in_cam_m.head<2>().norm(), in_cam_m.z()) * 180.0 / std::numbers::pi;
      sum_deg += error_deg;
      worst_deg = std::max(worst_deg, error_deg);
    }
    std::cout << "at " << distance_m << " m: mean " << sum_deg / poses << ", largest " << worst_deg
              << " deg\n";
    EXPECT_NEAR(sum_deg / poses, mean_deg, 0.05);
    EXPECT_NEAR(worst_deg, largest_deg, 0.06);
  }
}

TEST(Kinematics, TheEncodersAndTheControllersModelGiveTheTrueCamerasInMotion) {
  World world(WorldConfig{}, "", 1);
  PoseError error;
  const RandomStream random(12, "test/references");
  for (std::uint64_t i = 0; i < 1000; ++i) {
    if (i % 100 == 0) {
      HeadJointVector reference = HeadJointVector::Zero();
      for (int j = 0; j < head_joint_count; ++j) {
        const int joint = torso_joint_count + j;
        reference[j] = random.uniform(world.limits().min_rad[joint], world.limits().max_rad[joint], i,
                                      static_cast<std::uint64_t>(j));
      }
      ASSERT_TRUE(world.set_reference(reference));
    }
    world.step();
    const JointVector q = world.head_state().position_rad;
    error.add(world.root_from_left_cam(), root_from_left_cam(q));
    error.add(world.root_from_right_cam(), root_from_right_cam(q));
  }
  EXPECT_LT(error.position_m, 1e-9);
  EXPECT_LT(error.angle_rad, 1e-9);
}

TEST(Kinematics, TheCameraHasItsConfiguredPoseInTheEye) {
  const CameraMount mount{{1.0, -2.0, -10.0}, {0.0, 0.0, 10.0}};
  World world(WorldConfig{}, "", 1);
  world.mount_camera(world.left_eye_camera(), mount.eye_from_camera());
  for (int i = 0; i < 50; ++i) {
    const JointVector q = world.head_state().position_rad;
    const Eigen::Isometry3d expected = root_from_left_cam(q) * mount.eye_from_camera();
    ASSERT_LT((world.root_from_left_cam().matrix() - expected.matrix()).norm(), 1e-9);
    ASSERT_LT((world.root_from_right_cam().matrix() - root_from_right_cam(q).matrix()).norm(), 1e-9);
    HeadJointVector reference = HeadJointVector::Zero();
    reference.head(default_head()->gaze_joints()).setConstant(0.1);
    ASSERT_TRUE(world.set_reference(reference));
    world.step();
  }
  const Eigen::Isometry3d eye_from_camera =
      root_from_left_cam(world.head_state().position_rad).inverse() * world.root_from_left_cam();
  EXPECT_LT((eye_from_camera.translation() - Eigen::Vector3d(0.001, -0.002, -0.010)).norm(), 1e-9);
  const double turn_rad = 10.0 * std::numbers::pi / 180.0;
  EXPECT_NEAR(eye_from_camera.linear()(1, 0), std::sin(turn_rad),
              1e-9);  // x turns down: clockwise in the image
}

TEST(Kinematics, TheCameraMotionFromEncodersEqualsThatOfThePlant) {
  World world(WorldConfig{}, "", 1);
  HeadJointVector reference = HeadJointVector::Zero();
  reference.head<head_joint_count>() << 0.1, -0.1, 0.3, 0.2, -0.2, 0.3;
  ASSERT_TRUE(world.set_reference(reference));
  for (int i = 0; i < 100; ++i) {
    world.step();
    const CameraMotion motion = camera_motion(default_head()->chain, world.head_state());
    mjtNum velocity[6];  // angular, linear, in MuJoCo's camera-body frame, parallel to root at zero
    const int eye = mj_name2id(&world.model(), mjOBJ_BODY, "l_eye");
    mj_objectVelocity(&world.model(), &world.data(), mjOBJ_XBODY, eye, velocity, 0);
    const Eigen::Matrix3d camera_from_root = world.root_from_left_cam().linear().transpose();
    const Eigen::Vector3d angular = camera_from_root * Eigen::Map<const Eigen::Vector3d>(velocity);
    const Eigen::Vector3d linear = camera_from_root * Eigen::Map<const Eigen::Vector3d>(velocity + 3);
    ASSERT_LT((motion.angular_velocity_rad_s - angular).norm(), 1e-9);
    ASSERT_LT((motion.linear_velocity_m_s - linear).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace saccade
