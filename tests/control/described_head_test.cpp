#include "tests/control/described_head.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "control/controller_registry.h"
#include "core/error.h"
#include "head/ikin_links.h"
#include "tests/control/gaze_plant.h"
#include "tests/control/malloc_count.h"

namespace saccade {
namespace {

using testing::HasSubstr;

std::string complaint(const HeadDescription& head) {
  try {
    (void)described_head(head);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

double error_deg(const HeadModel& head, const JointVector& q, const Eigen::Vector3d& target_m) {
  const Eigen::Vector3d seen = HeadKinematics(head.chain, q).root_from_eye(Eye::left).inverse() * target_m;
  return std::atan2(seen.head<2>().norm(), seen.z()) * deg_per_rad;
}

TEST(DescribedHead, ByItsAxesTurnsAboutThem) {
  const auto head = described_head(pan_tilt());
  const double pan = 0.4, tilt = -0.3;
  JointVector q = JointVector::Zero();
  q[torso_slots] = pan;
  q[torso_slots + 1] = tilt;
  const Eigen::Isometry3d expected =
      Eigen::Translation3d(0, 0, 0.29) * Eigen::AngleAxisd(pan, -Eigen::Vector3d::UnitZ()) *
      Eigen::Translation3d(0, 0, 0.045) * Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()) *
      Eigen::Translation3d(-0.02, 0, 0.015) * Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d eye = HeadKinematics(head->chain, q).root_from_eye(Eye::left);
  EXPECT_LT((eye.translation() - expected.translation()).norm(), 1e-12);
  EXPECT_LT((eye.linear().col(2) - expected.linear() * Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((eye.linear().col(1) - expected.linear() * Eigen::Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_FALSE(HeadKinematics(head->chain, q).fixation().valid) << "one eye has no fixation point";
  EXPECT_FALSE(head->has_icub_gaze());
}

TEST(DescribedHead, OfTwelveJointsHasJacobiansLikeFiniteDifferences) {
  const auto head = described_head(twelve_joints());
  ASSERT_EQ(head->gaze_joints(), 12);
  const RandomStream random(3, "twelve");
  for (std::uint64_t i = 0; i < 20; ++i) {
    JointVector q = JointVector::Zero();
    for (const HeadJoint& joint : head->joints)
      q[joint.slot] = random.uniform(-0.6, 0.6, static_cast<std::uint64_t>(joint.slot), i);
    const EyeJacobian jacobian = HeadKinematics(head->chain, q).jacobian(Eye::right);
    for (const HeadJoint& joint : head->joints) {
      const auto place = [&](double by) {
        JointVector moved = q;
        moved[joint.slot] += by;
        return Eigen::Vector3d(HeadKinematics(head->chain, moved).root_from_eye(Eye::right).translation());
      };
      EXPECT_LT(((place(1e-5) - place(-1e-5)) / 2e-5 - jacobian.linear.col(joint.slot)).norm(), 1e-9)
          << joint.name;
    }
  }
}

TEST(DescribedHead, GazeReachesATargetWithAnyNumberOfJointsWithoutAllocating) {
  for (const HeadDescription& description : {pan_tilt(), twelve_joints()}) {
    const auto head = described_head(description);
    const auto gaze = make_gaze_controller(built_in_controllers().config(), limits_of(head));
    JointLimiter limiter(motion_limits(limits_of(head), {}));
    Plant plant(0.02);
    const Eigen::Isometry3d eye =
        HeadKinematics(head->chain, plant.state.position_rad).root_from_eye(Eye::left);
    const Eigen::Vector3d target_m = eye * Eigen::Vector3d(0.10, -0.06, 0.50);
    (void)gaze->step(plant.state, target_m, dt);
    const long before = malloc_count();
    for (int i = 0; i < 3000; ++i) {
      const HeadJointVector reference = gaze->step(plant.state, std::nullopt, dt);
      plant.follow(limiter.apply(reference, plant.state.head_position_rad(), dt).reference_rad);
    }
    if (malloc_is_counted()) {
      EXPECT_EQ(malloc_count(), before) << description.name;
    }
    // The redundant neck still takes over from the eyes, with a sixth of a pixel left.
    EXPECT_LT(error_deg(*head, plant.state.position_rad, target_m), 0.1) << description.name;
    for (int j = head->gaze_joints(); j < gaze_slots; ++j)
      EXPECT_EQ(plant.state.position_rad[torso_slots + j], 0.0);
  }
}

TEST(DescribedHead, IkingazeNeedsTheJointsOfAnIcub) {
  GazeControllerConfig config = built_in_controllers().config();
  config.controller = "ikingaze";
  try {
    (void)make_gaze_controller(config, limits_of(described_head(pan_tilt())));
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 1u);
    EXPECT_THAT(error.what(), HasSubstr("pan-tilt unit has others"));
  }
}

TEST(DescribedHead, WhatIsWrongIsNamed) {
  HeadDescription head = pan_tilt();
  head.links[1].second.joint = "none";
  EXPECT_THAT(complaint(head), HasSubstr("head.joints.tilt: found a joint that turns no link"));
  head = pan_tilt();
  head.left_eye.pose.reset();
  EXPECT_THAT(complaint(head), HasSubstr("head.left_eye.pose: found missing"));
  head = pan_tilt();
  head.joints[0].second.role = JointRole::eye;
  head.joints[1].second.role = JointRole::neck;
  EXPECT_THAT(complaint(head), HasSubstr("head.joints.tilt.role: found neck"));
  head = pan_tilt();
  head.links[1].second.second_joint = "pan";
  head.links[0].second.joint = "tilt";
  head.links[0].second.second_joint = "pan";
  EXPECT_THAT(complaint(head), HasSubstr("head.links: found joints that turn the same links"));
  head = pan_tilt();
  head.joints[0].second.role = head.joints[1].second.role = JointRole::torso;
  EXPECT_THAT(complaint(head), HasSubstr("head.joints: found no joint of neck or eyes"));
}

/// The eye chain of iKin's version 2 as a list of links.
std::string ikin_eye(const char* tilt_d, bool as_groups) {
  const std::vector<std::vector<std::string>> rows = {
      {"0.032", "0", "90", "0", "-20", "70"},      {"0", "-0.0055", "90", "-90", "-30", "30"},
      {"0", "-0.2233", "-90", "-90", "-50", "50"}, {"0.0095", "0", "90", "90", "-30", "17"},
      {"0", "0", "-90", "-90", "-20", "20"},       {"-0.0509", "0.08205", "-90", "90", "-45", "45"},
      {"0", tilt_d, "-90", "0", "-30", "30"},      {"0", "0", "90", "-90", "-30", "30"}};
  const std::vector<std::string> keys = {"A", "D", "alpha", "offset", "min", "max"};
  std::string text = "// an eye\ntype left\nH0 (0 -1 0 0  0 0 -1 0  1 0 0 0  0 0 0 1)\nnumLinks 8\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    text += as_groups ? "[link_" + std::to_string(i) + "]\n" : "link_" + std::to_string(i);
    for (std::size_t k = 0; k < keys.size(); ++k)
      text += as_groups ? keys[k] + "  " + rows[i][k] + "\n" : " (" + keys[k] + " " + rows[i][k] + ")";
    text += "\n";
  }
  return text;
}

TEST(IkinLinks, OfTheIcubGiveItsHead) {
  for (const bool as_groups : {false, true}) {
    const IkinText right{"right.ini", ikin_eye("0.034", as_groups)};
    const auto head =
        described_head(description_of_ikin({"left.ini", ikin_eye("-0.034", as_groups)}, &right));
    EXPECT_TRUE(head->has_icub_gaze());
    const RandomStream random(1, "ikin");
    for (std::uint64_t i = 0; i < 200; ++i) {
      const JointVector q = random_configuration(random, i);
      const HeadKinematics read(head->chain, q), own(default_head()->chain, q);
      for (const Eye eye : {Eye::left, Eye::right})
        EXPECT_LT((read.root_from_eye(eye).matrix() - own.root_from_eye(eye).matrix()).norm(), 1e-12);
    }
    for (std::size_t j = 0; j < head->joints.size(); ++j) {
      EXPECT_EQ(head->joints[j].name, default_head()->joints[j].name);
      EXPECT_NEAR(head->joints[j].max_rad, default_head()->joints[j].max_rad, 1e-12);
    }
  }
}

TEST(IkinLinks, BlockedLinksAreFixedAndOneEyeIsEnough) {
  std::string text = ikin_eye("0", false);
  for (const char* link : {"link_0", "link_1", "link_2"}) text.insert(text.find(link) + 6, " (blocked 0.0)");
  const auto head = described_head(description_of_ikin({"eye.ini", text}, nullptr));
  EXPECT_EQ(head->torso_joints(), 0);
  EXPECT_EQ(head->gaze_joints(), 5);
  EXPECT_EQ(head->chain.eyes, 1);
}

TEST(IkinLinks, ErrorsNameFileAndLine) {
  const auto complaint_of = [](const std::string& text) -> std::string {
    try {
      (void)description_of_ikin({"eye.ini", text}, nullptr);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_THAT(complaint_of(""), HasSubstr("eye.ini: found no numLinks"));
  EXPECT_THAT(complaint_of("numLinks 2\nlink_0 (A 1)\n"), HasSubstr("found 1 links, expected 2"));
  EXPECT_THAT(complaint_of("numLinks 1\nlink_0 (A x)\n"),
              HasSubstr("eye.ini:2: found x, expected a finite number"));
  EXPECT_THAT(complaint_of("numLinks 1\nlink_0 (B 1)\n"), HasSubstr("expected A, D, alpha"));
  EXPECT_THAT(complaint_of("numLinks 1\nH0 (1 2 3)\nlink_0 (A 1)\n"),
              HasSubstr("eye.ini:2: found 3 numbers"));
  EXPECT_THAT(complaint_of("numLinks 99\n"), HasSubstr("1 to 24"));
}

}  // namespace
}  // namespace saccade
