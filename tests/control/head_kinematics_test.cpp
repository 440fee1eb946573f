#include "control/head_kinematics.h"

#include <gtest/gtest.h>

#include "tests/control/genova02.h"

namespace saccade {
namespace {

const std::array<Eye, 2> both_eyes = {Eye::left, Eye::right};

/// What a rotation matrix's small change is, as a rotation vector.
Eigen::Vector3d small_rotation(const Eigen::Matrix3d& to, const Eigen::Matrix3d& from) {
  const Eigen::Matrix3d d = to * from.transpose();
  return 0.5 * Eigen::Vector3d(d(2, 1) - d(1, 2), d(0, 2) - d(2, 0), d(1, 0) - d(0, 1));
}

/// Central difference of a function of the configuration with an error of the fourth order in h.
template <class Function>
Eigen::Vector3d derivative(const Function& f, const JointVector& q, int joint, double h = 2e-3) {
  const auto at = [&](double step) {
    JointVector moved = q;
    moved[joint] += step;
    return f(moved);
  };
  // Seven-point stencil, error of order h^6.
  return ((at(3 * h) - at(-3 * h)) / 60.0 - (at(2 * h) - at(-2 * h)) * (3.0 / 20.0) +
          (at(h) - at(-h)) * (3.0 / 4.0)) /
         h;
}

TEST(HeadKinematics, PlacesTheEyesOfTheV2HeadAtZero) {
  const Eigen::Isometry3d left =
      HeadKinematics(default_head()->chain, JointVector::Zero()).root_from_eye(Eye::left);
  const Eigen::Isometry3d right =
      HeadKinematics(default_head()->chain, JointVector::Zero()).root_from_eye(Eye::right);
  EXPECT_LT((left.translation() - Eigen::Vector3d(-0.0564, -0.034, 0.34685)).norm(), 1e-12);
  EXPECT_LT((right.translation() - Eigen::Vector3d(-0.0564, 0.034, 0.34685)).norm(), 1e-12);
  Eigen::Matrix3d looking_ahead;  // x to the robot's right (root y), y down (-z), z ahead (-x)
  looking_ahead << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  EXPECT_LT((left.linear() - looking_ahead).norm(), 1e-12);
  EXPECT_LT((right.linear() - looking_ahead).norm(), 1e-12);
}

TEST(HeadKinematics, TurnsEveryJointAboutTheTabulatedAxis) {
  struct Row {
    Joint joint;
    Eigen::Vector3d axis, point_m;
  };
  const std::vector<Row> table = {
      {torso_pitch, {0, -1, 0}, {0, 0, 0}},
      {torso_roll, {1, 0, 0}, {0, 0, 0.032}},
      {torso_yaw, {0, 0, -1}, {-0.0055, 0, 0.032}},
      {neck_pitch, {0, 1, 0}, {-0.0055, 0, 0.2553}},
      {neck_roll, {-1, 0, 0}, {-0.0055, 0, 0.2648}},
      {neck_yaw, {0, 0, 1}, {-0.0055, 0, 0.2648}},
      {eyes_tilt, {0, 1, 0}, {-0.0564, 0, 0.34685}},
      {eyes_version, {0, 0, -1}, {-0.0564, -0.034, 0.34685}},
      {eyes_vergence, {0, 0, -1}, {-0.0564, 0.034, 0.34685}},
  };
  const HeadKinematics head(default_head()->chain, JointVector::Zero());
  for (const Row& row : table) {
    const Eye eye = row.joint == eyes_vergence ? Eye::right : Eye::left;  // the pan of the eye
    EXPECT_LT((head.axis(row.joint, eye) - row.axis).norm(), 1e-12)
        << joint_names[static_cast<std::size_t>(row.joint)];
    // A point on the axis is free to slide along it.
    EXPECT_LT(row.axis.cross(head.point_on_axis(row.joint, eye) - row.point_m).norm(), 1e-12)
        << joint_names[static_cast<std::size_t>(row.joint)];
  }
  EXPECT_LT((head.chest_forward() - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);
}

TEST(HeadKinematics, EqualsTheProductOfTheTabulatedAxes) {
  // Poses as a product of turns about the axes at q = 0: no DH parameter is used.
  const HeadKinematics zero(default_head()->chain, JointVector::Zero());
  const RandomStream random(1, "kinematics");
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const JointVector q = random_configuration(random, i);
    const HeadKinematics head(default_head()->chain, q);
    Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
    const auto turn = [&](Joint joint, double angle, Eye eye = Eye::left) {
      turned = turned * Eigen::Translation3d(zero.point_on_axis(joint, eye)) *
               Eigen::AngleAxisd(angle, zero.axis(joint, eye)) *
               Eigen::Translation3d(-zero.point_on_axis(joint, eye));
    };
    for (int j = 0; j <= eyes_tilt; ++j) turn(static_cast<Joint>(j), q[j]);
    const Eigen::Isometry3d to_tilt = turned;
    turn(eyes_version, q[eyes_version] + q[eyes_vergence] / 2);
    EXPECT_LT(
        (head.root_from_eye(Eye::left).matrix() - (turned * zero.root_from_eye(Eye::left)).matrix()).norm(),
        1e-12);
    turned = to_tilt;
    turn(eyes_vergence, q[eyes_version] - q[eyes_vergence] / 2, Eye::right);
    EXPECT_LT(
        (head.root_from_eye(Eye::right).matrix() - (turned * zero.root_from_eye(Eye::right)).matrix()).norm(),
        1e-12);
  }
}

TEST(HeadKinematics, JacobianOfAnEyeEqualsFiniteDifferences) {
  const RandomStream random(2, "kinematics");
  for (std::uint64_t i = 0; i < 200; ++i) {
    const JointVector q = random_configuration(random, i);
    for (const Eye eye : both_eyes) {
      const HeadKinematics head(default_head()->chain, q);
      const EyeJacobian j = head.jacobian(eye);
      const Eigen::Matrix3d here = head.root_from_eye(eye).linear();
      for (int joint = 0; joint < joint_count; ++joint) {
        const auto centre = [&](const JointVector& at) {
          return Eigen::Vector3d(HeadKinematics(default_head()->chain, at).root_from_eye(eye).translation());
        };
        // sin(angle) axis differs from the rotation vector in the third order, which the stencil keeps.
        const auto rotation = [&](const JointVector& at) {
          const Eigen::AngleAxisd turn(Eigen::Matrix3d(
              HeadKinematics(default_head()->chain, at).root_from_eye(eye).linear() * here.transpose()));
          const Eigen::Vector3d sine =
              small_rotation(HeadKinematics(default_head()->chain, at).root_from_eye(eye).linear(), here);
          return Eigen::Vector3d(sine * (turn.angle() / std::sin(turn.angle())));
        };
        EXPECT_LT((j.linear.col(joint) - derivative(centre, q, joint)).norm(), 1e-9);
        EXPECT_LT((j.angular.col(joint) - derivative(rotation, q, joint)).norm(), 1e-9);
      }
    }
  }
}

TEST(HeadKinematics, FixationPointIsTheIntersectionOfBothAxes) {
  const RandomStream random(3, "kinematics");
  int seen = 0;
  for (std::uint64_t i = 0; i < 500; ++i) {
    const HeadKinematics head(default_head()->chain, random_configuration(random, i));
    const FixationPoint fixation = head.fixation();
    if (!fixation.valid) continue;
    ++seen;
    // The eyes share tilt and pan in one plane: the axes meet, and the point lies on both.
    for (const Eye eye : both_eyes) {
      const Eigen::Vector3d in_eye = head.root_from_eye(eye).inverse() * fixation.point_m;
      EXPECT_LT(in_eye.head<2>().norm(), 1e-9);
      EXPECT_GT(in_eye.z(), 0.0);
    }
  }
  EXPECT_GT(seen, 400);
}

TEST(HeadKinematics, VergenceGivesTheTabulatedDistance) {
  // Symmetric vergence g over a baseline of 68 mm crosses at 34 mm / tan(g / 2): 8.64 deg at 0.45 m.
  for (const auto& [vergence_deg, distance_m] :
       {std::pair{8.64, 0.45}, {12.93, 0.30}, {15.49, 0.25}, {3.89, 1.0}}) {
    JointVector q = JointVector::Zero();
    q[eyes_vergence] = vergence_deg * rad_per_deg;
    const FixationPoint fixation = HeadKinematics(default_head()->chain, q).fixation();
    ASSERT_TRUE(fixation.valid);
    EXPECT_NEAR(fixation.point_m.x(), -0.0564 - distance_m, 2e-3 * distance_m);
    EXPECT_NEAR(fixation.point_m.y(), 0.0, 1e-12);
    EXPECT_NEAR(fixation.point_m.z(), 0.34685, 1e-12);
  }
}

TEST(HeadKinematics, FixationIsInvalidIfTheAxesAreParallelOrIntersectBehind) {
  JointVector q = JointVector::Zero();
  EXPECT_FALSE(HeadKinematics(default_head()->chain, q).fixation().valid);
  q[eyes_vergence] = 0.05 * rad_per_deg;
  EXPECT_FALSE(HeadKinematics(default_head()->chain, q).fixation().valid);
  q[eyes_vergence] = -5.0 * rad_per_deg;
  EXPECT_FALSE(HeadKinematics(default_head()->chain, q).fixation().valid);
  EXPECT_TRUE(HeadKinematics(default_head()->chain, q).fixation_jacobian().isZero(0.0));
}

TEST(HeadKinematics, JacobianOfTheFixationPointEqualsFiniteDifferences) {
  const RandomStream random(4, "kinematics");
  for (std::uint64_t i = 0; i < 200; ++i) {
    JointVector q = random_configuration(random, i);
    q[eyes_vergence] =
        random.uniform(0.15, 0.8, 99, i);  // near enough that the differences are exact to 1e-9
    const PointJacobian j = HeadKinematics(default_head()->chain, q).fixation_jacobian();
    for (int joint = 0; joint < joint_count; ++joint) {
      const auto fixation = [](const JointVector& at) {
        return HeadKinematics(default_head()->chain, at).fixation().point_m;
      };
      EXPECT_LT((j.col(joint) - derivative(fixation, q, joint, 4e-4)).norm(), 1e-9) << i << " " << joint;
    }
  }
}

TEST(HeadKinematics, CameraMotionIsTheDerivativeOfThePoseInItsOwnFrame) {
  const RandomStream random(5, "kinematics");
  for (std::uint64_t i = 0; i < 100; ++i) {
    HeadState state;
    state.position_rad = random_configuration(random, i);
    for (int j = 0; j < joint_count; ++j) {
      state.velocity_rad_s[j] = random.uniform(-3.0, 3.0, static_cast<std::uint64_t>(50 + j), i);
    }
    const bool off_centre = i % 2 == 1;
    const CameraMount mount{{1.0, -2.0, -10.0}, {20.0, -30.0, 10.0}};
    const Eigen::Isometry3d eye_from_camera = (off_centre ? mount : CameraMount{}).eye_from_camera();
    for (const Eye eye : both_eyes) {
      const CameraMotion motion = off_centre
                                      ? camera_motion(default_head()->chain, state, eye, eye_from_camera)
                                      : camera_motion(default_head()->chain, state, eye);
      const double h = 1e-5;
      const auto pose_at = [&](double t_s) {
        return HeadKinematics(default_head()->chain, state.position_rad + t_s * state.velocity_rad_s)
                   .root_from_eye(eye) *
               eye_from_camera;
      };
      const Eigen::Matrix3d cam_from_root = motion.root_from_camera.linear().transpose();
      const Eigen::Vector3d linear = (pose_at(h).translation() - pose_at(-h).translation()) / (2 * h);
      const Eigen::Vector3d angular = small_rotation(pose_at(h).linear(), pose_at(-h).linear()) / (2 * h);
      EXPECT_EQ(motion.root_from_camera.matrix(), pose_at(0.0).matrix());
      EXPECT_LT((motion.linear_velocity_m_s - cam_from_root * linear).norm(), 1e-7);
      EXPECT_LT((motion.angular_velocity_rad_s - cam_from_root * angular).norm(), 1e-7);
    }
  }
}

TEST(HeadKinematics, ReachesTheReferencePosesOfTheNeck) {
  // Neck poses (deg) that iKin's solver gives for targets (m): the axis between the eyes points at them.
  struct Pose {
    Eigen::Vector3d target_m;
    double pitch, roll, yaw;
  };
  for (const Pose& pose :
       {Pose{{-0.5, 0.15, 0.25}, -9.7, 5.2, -16.3}, Pose{{-0.5, 0.15, 0.45}, 11.4, -0.7, -16.1},
        Pose{{-0.356, 0.15, 0.25}, -12.2, 8.9, -22.0}}) {
    for (const double side : {1.0, -1.0}) {
      JointVector q = JointVector::Zero();
      q[neck_pitch] = pose.pitch * rad_per_deg;
      q[neck_roll] = side * pose.roll * rad_per_deg;
      q[neck_yaw] = side * pose.yaw * rad_per_deg;
      const HeadKinematics head(default_head()->chain, q);
      const Eigen::Vector3d between =
          0.5 * (head.root_from_eye(Eye::left).translation() + head.root_from_eye(Eye::right).translation());
      const Eigen::Vector3d target(pose.target_m.x(), side * pose.target_m.y(), pose.target_m.z());
      const Eigen::Vector3d axis = head.root_from_eye(Eye::left).linear().col(2);
      EXPECT_LT(std::asin(axis.cross((target - between).normalized()).norm()) / rad_per_deg, 0.1);
    }
  }
}

TEST(HeadKinematics, TheNeckAtItsUpperLimitMissesAHighTarget) {
  // (-0.5, 0, 0.55) leaves 5.1 deg of elevation with neck pitch at its 17 deg.
  JointVector q = JointVector::Zero();
  q[neck_pitch] = 17.0 * rad_per_deg;
  const HeadKinematics head(default_head()->chain, q);
  const Eigen::Vector3d between =
      0.5 * (head.root_from_eye(Eye::left).translation() + head.root_from_eye(Eye::right).translation());
  const Eigen::Vector3d target = Eigen::Vector3d(-0.5, 0.0, 0.55) - between;
  const Eigen::Vector3d axis = head.root_from_eye(Eye::left).linear().col(2);
  EXPECT_NEAR(std::asin(axis.cross(target.normalized()).norm()) / rad_per_deg, 5.1, 0.05);
}

}  // namespace
}  // namespace saccade
