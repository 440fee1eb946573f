#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include "control/controller_registry.h"
#include "control/head_kinematics.h"
#include "core/random.h"
#include "core/units.h"
#include "tests/control/described_head.h"
#include "tests/control/gaze_plant.h"
#include "tests/control/malloc_count.h"

namespace saccade {
namespace {

/// The eye chains of iKin (iKinFwd.cpp) as its tables have them: A, D in m, alpha, offset in quarters of a turn; each eye
/// has a row of the tilt and of the pan of its own.
struct TableRow {
  double a, d, alpha, offset;
};
struct Table {
  const char* version;
  std::vector<TableRow> rows;  ///< torso, in the order of the chain, and neck
  std::array<int, 3> torso;    ///< joint of each row of the torso
  double camera_z_m;           ///< of HN
};

const std::vector<Table> tables = {
    {"1",
     {{0.032, 0, 1, 0},
      {0, -0.0055, 1, -1},
      {0.00231, -0.1933, -1, -1},
      {0.033, 0, 1, 1},
      {0, 0.001, -1, -1},
      {-0.054, 0.0825, -1, 1}},
     {torso_pitch, torso_roll, torso_yaw},
     0.0},
    {"2",
     {{0.032, 0, 1, 0},
      {0, -0.0055, 1, -1},
      {0, -0.2233, -1, -1},
      {0.0095, 0, 1, 1},
      {0, 0, -1, -1},
      {-0.0509, 0.08205, -1, 1}},
     {torso_pitch, torso_roll, torso_yaw},
     0.0},
    {"2.8",
     {{0.032, 0, 1, 0},
      {0, -0.0055, 1, -1},
      {0, -0.2233, -1, -1},
      {0.0095, 0, 1, 1},
      {0, 0, -1, -1},
      {-0.0509, 0.08205, -1, 1}},
     {torso_pitch, torso_roll, torso_yaw},
     -0.010},
    {"2.10",
     {{0.032, 0, 1, 0},
      {0, -0.0055, 1, -1},
      {0.0053, -0.2233, -1, -1},
      {0.0110, 0, 1, 1},
      {0, 0, -1, -1},
      {-0.0510, 0.08052, -1, 1}},
     {torso_pitch, torso_roll, torso_yaw},
     -0.00983},
    {"3",
     {{0.0725, 0, -1, 0},
      {0, 0, 1, -1},
      {-0.00486151, -0.26377, -1, 2},
      {0.0095, 0, 1, 1},
      {0, 0, -1, -1},
      {-0.0509, 0.08205, -1, 1}},
     {torso_roll, torso_pitch, torso_yaw},
     0.0},
};

Eigen::Matrix4d row_matrix(const TableRow& row, double q) {
  const double theta = q + row.offset * std::numbers::pi / 2, alpha = row.alpha * std::numbers::pi / 2;
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t = t * Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(row.a, 0.0, row.d) *
      Eigen::AngleAxisd(alpha, Eigen::Vector3d::UnitX());
  return t.matrix();
}

Eigen::Matrix4d table_eye(const Table& table, const JointVector& q, bool left) {
  Eigen::Matrix4d t = Eigen::Matrix4d::Zero();
  if (std::string_view(table.version) == "3") {
    t << 0, 0, 1, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1;
  } else {
    t << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 1;
  }
  for (std::size_t i = 0; i < 6; ++i)
    t = t * row_matrix(table.rows[i], q[i < 3 ? table.torso[i] : static_cast<int>(i)]);
  t = t * row_matrix({0, left ? -0.034 : 0.034, -1, 0}, q[eyes_tilt]);
  const double half = q[eyes_vergence] / 2;
  t = t * row_matrix({0, 0, 1, -1}, left ? q[eyes_version] + half : q[eyes_version] - half);
  t.col(3) += table.camera_z_m * t.col(2);
  return t;
}

TEST(IcubVersions, EqualTheTablesOfIkinInAThousandPoses) {
  const RandomStream random(1, "versions");
  for (const Table& table : tables) {
    const auto head = icub_head(table.version);
    ASSERT_NE(head, nullptr) << table.version;
    double worst = 0.0;
    for (std::uint64_t i = 0; i < 1000; ++i) {
      JointVector q = JointVector::Zero();
      for (const HeadJoint& joint : head->joints)
        q[joint.slot] =
            random.uniform(joint.min_rad, joint.max_rad, static_cast<std::uint64_t>(joint.slot), i);
      const HeadKinematics at(head->chain, q);
      worst = std::max(
          {worst, (at.root_from_eye(Eye::left).matrix() - table_eye(table, q, true)).cwiseAbs().maxCoeff(),
           (at.root_from_eye(Eye::right).matrix() - table_eye(table, q, false)).cwiseAbs().maxCoeff()});
    }
    std::cout << "version " << table.version << ": " << worst << " at most\n";
    EXPECT_LT(worst, 1e-12) << "version " << table.version;
  }
}

TEST(IcubVersions, HaveTheirEyesAtTheTabulatedPlaces) {
  const std::vector<std::pair<const char*, Eigen::Vector3d>> places = {{"1", {-0.06281, -0.034, 0.3408}},
                                                                       {"2", {-0.0564, -0.034, 0.34685}},
                                                                       {"2.10", {-0.0618, -0.034, 0.34682}},
                                                                       {"3", {-0.04604, -0.034, 0.42782}}};
  for (const auto& [version, place] : places) {
    const auto head = icub_head(version);
    const Eigen::Isometry3d eye = HeadKinematics(head->chain, JointVector::Zero()).root_from_eye(Eye::left);
    // The table gives the centres of the eyes, to 0.01 mm.
    const double ahead_m = head->chain.eye_from_last[0].translation().z();
    EXPECT_LT((eye.translation() - ahead_m * eye.linear().col(2) - place).norm(), 1e-5) << version;
  }
}

TEST(IcubVersions, JacobiansEqualFiniteDifferences) {
  const RandomStream random(2, "versions");
  for (const Table& table : tables) {
    const auto head = icub_head(table.version);
    for (std::uint64_t i = 0; i < 20; ++i) {
      JointVector q = JointVector::Zero();
      for (const HeadJoint& joint : head->joints)
        q[joint.slot] =
            random.uniform(joint.min_rad, joint.max_rad, static_cast<std::uint64_t>(joint.slot), i);
      for (const Eye eye : {Eye::left, Eye::right}) {
        const EyeJacobian jacobian = HeadKinematics(head->chain, q).jacobian(eye);
        for (const HeadJoint& joint : head->joints) {
          constexpr double step = 1e-5;
          const auto place = [&](double by) {
            JointVector moved = q;
            moved[joint.slot] += by;
            return Eigen::Vector3d(HeadKinematics(head->chain, moved).root_from_eye(eye).translation());
          };
          const Eigen::Vector3d slope = (place(step) - place(-step)) / (2.0 * step);
          EXPECT_LT((slope - jacobian.linear.col(joint.slot)).norm(), 1e-9)
              << table.version << " " << joint.name;
        }
      }
    }
  }
}

TEST(IcubVersions, BothControllersPointTheLeftEyeAtATarget) {
  for (const Table& table : tables) {
    const auto head = icub_head(table.version);
    for (const char* name : {"qp", "ikingaze"}) {
      GazeControllerConfig config = built_in_controllers().config();
      config.controller = name;
      const auto gaze = make_gaze_controller(config, limits_of(head));
      Plant plant(0.0);
      const Eigen::Isometry3d eye =
          HeadKinematics(head->chain, plant.state.position_rad).root_from_eye(Eye::left);
      const Eigen::Vector3d target_m = eye * Eigen::Vector3d(0.08, 0.05, 0.45);
      run(*gaze, plant, target_m, 6.0);
      const Eigen::Vector3d seen =
          HeadKinematics(head->chain, plant.state.position_rad).root_from_eye(Eye::left).inverse() * target_m;
      EXPECT_LT(std::atan2(seen.head<2>().norm(), seen.z()) * deg_per_rad, 0.1)
          << table.version << " " << name;
    }
  }
}

TEST(IcubVersions, PursuitWithBothControllersDoesNotAllocate) {
  if (!malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc";
  for (const std::string& version : icub_versions()) {
    const auto head = icub_head(version);
    const Eigen::Isometry3d eye = HeadKinematics(head->chain, JointVector::Zero()).root_from_eye(Eye::left);
    for (const char* name : {"qp", "ikingaze"}) {
      GazeControllerConfig config = built_in_controllers().config();
      config.controller = name;
      const auto gaze = make_gaze_controller(config, limits_of(head));
      Plant plant;
      const long before = malloc_count();
      for (int i = 0; i < 2000; ++i) {
        const double angle = 2.0 * std::numbers::pi * i * dt;
        const Eigen::Vector3d target_m =
            eye * Eigen::Vector3d(0.07 * std::cos(angle), 0.07 * std::sin(angle), 0.45);
        plant.follow(gaze->step(plant.state, target_m, dt));
      }
      EXPECT_EQ(malloc_count(), before) << version << " " << name;
    }
  }
}

TEST(IcubVersions, AreNamedAsWritten) {
  EXPECT_EQ(icub_head("2.1"), nullptr);
  EXPECT_EQ(icub_head("2.0"), nullptr);
  EXPECT_EQ(icub_head(""), nullptr);
  EXPECT_NE(icub_head("2.10"), nullptr);
}

}  // namespace
}  // namespace saccade
