#include "sim/motion_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/units.h"
#include "sim/trajectory.h"

namespace saccade {
namespace {

using testing::HasSubstr;

/// A table in a file of its own.
class MotionFile : public testing::Test {
 protected:
  MotionFileConfig table(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    MotionFileConfig config;
    config.file = path_.string();
    return config;
  }
  /// The only problem of a table.
  std::string problem(const std::string& text) {
    const MotionFileConfig config = table(text);
    try {
      static_cast<void>(read_motion_file(config));
    } catch (const InputError& error) {
      EXPECT_EQ(error.problems().size(), 1U) << error.what();
      return error.problems().front().text();
    }
    ADD_FAILURE() << "was read without a complaint";
    return {};
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::filesystem::path path_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".csv");
};

TEST_F(MotionFile, GivesThePositionOfEveryRow) {
  const MotionTable table = read_motion_file(
      this->table("# from a mocap "
                  "system\nt_s,x_m,y_m,z_m\r\n12.0,0.1,0.2,0.3\n12.01,0.11,0.2,0.28\n\n12.05,0.2,0.1,0.3\n"));
  EXPECT_FALSE(table.turns);
  EXPECT_EQ(table.track.position_m(0.0), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_LT((table.track.position_m(0.01) - Eigen::Vector3d(0.11, 0.2, 0.28)).norm(), 1e-12);
  EXPECT_EQ(table.track.position_m(7.0), Eigen::Vector3d(0.2, 0.1, 0.3));
  EXPECT_EQ(table.track.position_m(-1.0), Eigen::Vector3d(0.1, 0.2, 0.3));
}

TEST_F(MotionFile, FollowsASmoothMotionBetweenItsRows) {
  std::string text = "t_s,x_m,y_m,z_m\n";
  const auto at = [](double t_s) {
    return Eigen::Vector3d(-0.5, 0.1 * std::sin(3.0 * t_s), 0.1 * std::cos(3.0 * t_s));
  };
  for (int row = 0; row < 240; ++row) {
    const double t_s = row / 120.0;
    text += text_of(t_s) + "," + text_of(at(t_s).x()) + "," + text_of(at(t_s).y()) + "," +
            text_of(at(t_s).z()) + "\n";
  }
  const MotionTable table = read_motion_file(this->table(text));
  // The error of a cubic through samples h apart is at most about h^3 max|x'''| / 16 in the slopes' order.
  for (double t_s = 0.02; t_s < 1.9; t_s += 0.0007) {
    EXPECT_LT((table.track.position_m(t_s) - at(t_s)).norm(), 1e-6) << t_s;
  }
}

TEST_F(MotionFile, LetsColumnsComeInAnyOrderAndTurnsOnTheShorterWay) {
  // -q is the same orientation as q.
  const MotionTable table = read_motion_file(
      this->table("qw,qx,qy,qz,t_s,z_m,y_m,x_m\n1,0,0,0,0,3,2,1\n-0.7071068,0,0,-0.7071068,0.1,3,2,1\n"));
  EXPECT_TRUE(table.turns);
  EXPECT_EQ(table.track.position_m(0.0), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_NEAR(Eigen::AngleAxisd(table.track.turn(0.05)).angle(), 45.0 * rad_per_deg, 1e-6);
}

TEST_F(MotionFile, IsMovedIntoTheRootFrame) {
  MotionFileConfig config =
      table("t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,1,0,0,1,0,0,0\n0.1,1,0,0,0.7071068,0.7071068,0,0\n");
  config.origin_m = {0.0, 0.0, 0.5};
  config.axes_turn_deg = {0.0, 0.0, 90.0};
  const MotionTable table = read_motion_file(config);
  EXPECT_LT((table.track.position_m(0.0) - Eigen::Vector3d(0.0, 1.0, 0.5)).norm(), 1e-12);
  EXPECT_LT(table.track.turn(0.0).angularDistance(Eigen::Quaterniond::Identity()), 1e-12);
  // A quarter about the table's x, which is the root's y.
  EXPECT_LT((table.track.turn(0.1) * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-6);
}

TEST_F(MotionFile, NamesTheLineOfEveryMistake) {
  const std::string three = "t_s,x_m,y_m,z_m\n0,0,0,0\n";
  const std::string seven = "t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n";
  EXPECT_THAT(
      problem(three + "0.5,0,0,0\n"),
      HasSubstr("csv:3: t_s: found 0.5 (line 2 is at 0), expected rows at most max_gap_s (0.1 s) apart"));
  EXPECT_THAT(problem(three + "0,0,0,0\n"),
              HasSubstr("csv:3: t_s: found 0 (line 2 is at 0), expected a later time"));
  EXPECT_THAT(problem(three + "-0.01,0,0,0\n"), HasSubstr("csv:3: t_s: found -0.01"));
  EXPECT_THAT(problem(three + "0.01,nan,0,0\n"),
              HasSubstr("csv:3: x_m: found \"nan\", expected a finite number"));
  EXPECT_THAT(problem(three + "0.01,0,,0\n"), HasSubstr("csv:3: y_m: found an empty cell"));
  EXPECT_THAT(problem(three + "0.01,0,0\n"), HasSubstr("csv:3: found 3 cells, expected 4 cells"));
  EXPECT_THAT(problem(three + "0.01,512,0,0\n"),
              HasSubstr("csv:3: found a position 512 m from the root, expected positions in metres"));
  EXPECT_THAT(problem(seven + "0.01,0,0,0,0,0,90,0\n"),
              HasSubstr("csv:3: qw,qx,qy,qz: found a quaternion of length 90, expected a unit quaternion "
                        "(not angles in degrees)"));
  EXPECT_THAT(problem("t_s,x_m,y_m,z_m,roll_deg,pitch_deg,yaw_deg\n"),
              HasSubstr("csv:1: found the column \"roll_deg\", expected a header"));
  EXPECT_THAT(problem("t_s,x_m,y_m\n0,0,0\n"), HasSubstr("csv:1: found no column z_m"));
  EXPECT_THAT(problem("t_s,x_m,y_m,z_m,qw,qx\n"), HasSubstr("csv:1: found no column qy"));
  EXPECT_THAT(problem("0,0,0,0\n0.01,0,0,0\n"), HasSubstr("csv:1: found the column \"0\""));
  EXPECT_THAT(problem(three), HasSubstr("csv:2: found 1 rows, expected at least two rows"));
  EXPECT_THAT(problem(""), HasSubstr("a readable table of a motion"));
}

TEST_F(MotionFile, ReportsAtMostTwentyMistakes) {
  std::string text = "t_s,x_m,y_m,z_m\n";
  for (int row = 0; row < 100; ++row) text += text_of(0.01 * row) + ",x,0,0\n";
  const MotionFileConfig config = table(text);
  try {
    static_cast<void>(read_motion_file(config));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 20U);
  }
}

TEST_F(MotionFile, MovesATrajectoryFromItsStart) {
  TrajectoryConfig config;
  config.kind = TrajectoryKind::csv;
  config.csv = table("t_s,x_m,y_m,z_m\n3,-0.5,0,0.3\n3.1,-0.5,0.1,0.3\n");
  config.start_s = 0.5;
  config.sway_m = 0.0;
  const Trajectory trajectory(config, 1);
  EXPECT_EQ(trajectory.first_motion_us(), 500'000);
  EXPECT_EQ(trajectory.position_m(400'000), Eigen::Vector3d(-0.5, 0.0, 0.3));
  EXPECT_LT((trajectory.position_m(550'000) - Eigen::Vector3d(-0.5, 0.05, 0.3)).norm(), 1e-12);
  EXPECT_LT((trajectory.position_m(900'000) - Eigen::Vector3d(-0.5, 0.1, 0.3)).norm(), 1e-12);
}

}  // namespace
}  // namespace saccade
