#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "config/head_section.h"
#include "config/scenario.h"
#include "config/source_keys.h"
#include "config/urdf_head.h"
#include "config/xml_file.h"
#include "config/yaml_writer.h"
#include "control/head_kinematics.h"
#include "core/random.h"
#include "core/units.h"
#include "head/ergocub_heads.h"
#include "sim/mjcf_chain.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Forward kinematics from the XML with arithmetic of its own: 4x4 matrices by rows.
using Matrix = std::array<std::array<double, 4>, 4>;
using Triple = std::array<double, 3>;
using Positions = std::map<std::string, double>;  // of joints by name, rad

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
  return c;
}

Matrix moved(const Triple& by) {
  return {{{1, 0, 0, by[0]}, {0, 1, 0, by[1]}, {0, 0, 1, by[2]}, {0, 0, 0, 1}}};
}

Matrix about(Triple axis, double angle) {
  const double length = std::hypot(axis[0], axis[1], axis[2]);
  for (double& element : axis) element /= length;
  const auto [x, y, z] = axis;
  const double c = std::cos(angle), s = std::sin(angle), t = 1 - c;
  return {{{t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0},
           {t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0},
           {t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0},
           {0, 0, 0, 1}}};
}

Triple triple_of(const char* text, Triple usual) {
  std::istringstream words(text);
  Triple read = usual;
  if (*text != '\0') words >> read[0] >> read[1] >> read[2];
  return read;
}

/// The pose of a URDF's link in the link above all others.
Matrix urdf_pose(const pugi::xml_node& robot, const std::string& link, const Positions& positions) {
  for (const pugi::xml_node joint : robot.children("joint")) {
    if (link != joint.child("child").attribute("link").value()) continue;
    const pugi::xml_node origin = joint.child("origin");
    const Triple rpy = triple_of(origin.attribute("rpy").value(), {0, 0, 0});
    Matrix pose = urdf_pose(robot, joint.child("parent").attribute("link").value(), positions);
    pose = product(pose, moved(triple_of(origin.attribute("xyz").value(), {0, 0, 0})));
    pose = product(pose, about({0, 0, 1}, rpy[2]));
    pose = product(pose, about({0, 1, 0}, rpy[1]));
    pose = product(pose, about({1, 0, 0}, rpy[0]));
    const auto position = positions.find(joint.attribute("name").value());
    if (position == positions.end()) return pose;
    return product(
        pose, about(triple_of(joint.child("axis").attribute("xyz").value(), {1, 0, 0}), position->second));
  }
  return moved({0, 0, 0});
}

/// The pose of an MJCF's camera in the world. Orientations are axes with angles in degrees.
Matrix mjcf_pose(const pugi::xml_node& element, const Positions& positions) {
  if (std::string(element.name()) == "worldbody") return moved({0, 0, 0});
  Matrix pose = mjcf_pose(element.parent(), positions);
  pose = product(pose, moved(triple_of(element.attribute("pos").value(), {0, 0, 0})));
  double angle_deg = 0.0;
  Triple axis = {0, 0, 1};
  std::istringstream turn(element.attribute("axisangle").value());
  if (element.attribute("axisangle")) turn >> axis[0] >> axis[1] >> axis[2] >> angle_deg;
  pose = product(pose, about(axis, angle_deg * rad_per_deg));
  for (const pugi::xml_node joint : element.children("joint")) {
    const Triple at = triple_of(joint.attribute("pos").value(), {0, 0, 0});
    const auto position = positions.find(joint.attribute("name").value());
    if (position == positions.end()) continue;
    pose = product(pose, moved(at));
    pose = product(pose, about(triple_of(joint.attribute("axis").value(), {0, 0, 1}), position->second));
    pose = product(pose, moved({-at[0], -at[1], -at[2]}));
  }
  return pose;
}

/// The largest difference of an element between a head's eye and a camera's pose in the file, over random positions.
/// `root` and `camera`: the root frame from the file's, and the file's camera from one with z along the optical axis.
double largest_error(const HeadModel& head, Eye eye, const Matrix& root, const Matrix& camera,
                     const std::function<Matrix(const Positions&)>& pose) {
  const RandomStream random(20, "test/model heads");
  double error = 0.0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    JointVector q = JointVector::Zero();
    Positions positions;
    for (const HeadJoint& joint : head.joints) {
      q[joint.slot] = random.uniform(joint.min_rad, joint.max_rad, i, static_cast<std::uint64_t>(joint.slot));
      positions[joint.name] = q[joint.slot];
    }
    const Matrix expected = product(product(root, pose(positions)), camera);
    const Eigen::Matrix4d found = HeadKinematics(head.chain, q).root_from_eye(eye).matrix();
    for (std::size_t r = 0; r < 4; ++r)
      for (std::size_t c = 0; c < 4; ++c)
        error = std::max(error, std::abs(expected[r][c] - found(static_cast<int>(r), static_cast<int>(c))));
  }
  return error;
}

const Matrix half_turn = about({0, 0, 1}, std::acos(-1.0));  // root from a frame with x forward, y left, z up
const Matrix no_turn = moved({0, 0, 0});
const Matrix body_camera =
    product(about({0, 0, 1}, -0.5 * std::acos(-1.0)), about({1, 0, 0}, -0.5 * std::acos(-1.0)));
const Matrix mujoco_camera = about({1, 0, 0}, std::acos(-1.0));

const std::string scenario_start = R"(name: mine
run: {duration_s: 1}
ball: {trajectory: {kind: hold, points_m: [[-0.5, 0, 0.35]]}}
detectors: {best: {}}
gaze: {detector: best}
)";

Scenario scenario_with(const TempFolder& folder, const std::string& head) {
  return read_scenario(folder.write("mine.yaml", scenario_start + "head: " + head + "\n"), {}, std::nullopt,
                       built_in());
}

std::shared_ptr<const HeadModel> head_with(const TempFolder& folder, const std::string& head) {
  return head_model(scenario_with(folder, head).sim.world.head);
}

std::string complaint_about(const TempFolder& folder, const std::string& head) {
  try {
    (void)scenario_with(folder, head);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

/// Torso, neck and two eyes, with fixed joints between, a joint that stays at 0, and others that are not the head's.
const std::string two_eyes = R"(<?xml version="1.0"?>
<robot name="two_eyes">
  <link name="base"/><link name="waist"/><link name="chest"/><link name="mount"/><link name="neck"/>
  <link name="head"/><link name="l_eye"/><link name="r_eye"/><link name="l_cam"/><link name="r_cam"/><link name="arm"/>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="waist"/><origin xyz="0.1 -0.02 0.3"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.4" effort="1" velocity="1"/></joint>
  <joint name="torso_yaw" type="revolute"><parent link="waist"/><child link="chest"/>
    <origin xyz="0.01 0.02 0.1" rpy="0.02 -0.1 0.3"/><axis xyz="0.1 0 -2"/>
    <limit lower="-0.7" upper="0.6" effort="1" velocity="1.5"/></joint>
  <joint name="mounting" type="fixed"><parent link="chest"/><child link="mount"/>
    <origin xyz="0 0.01 0.2" rpy="0.1 0.2 -0.3"/></joint>
  <joint name="shoulder" type="revolute"><parent link="chest"/><child link="arm"/></joint>
  <joint name="nod" type="revolute"><parent link="mount"/><child link="neck"/>
    <origin xyz="0.02 0 0.05" rpy="0 0.05 0"/><axis xyz="0 1 0.2"/>
    <limit lower="-0.5" upper="0.4" effort="1" velocity="2"/></joint>
  <joint name="turn" type="continuous"><parent link="neck"/><child link="head"/><origin xyz="0 0 0.06"/>
    <limit effort="1" velocity="2.5"/></joint>
  <joint name="l_pan" type="revolute"><parent link="head"/><child link="l_eye"/><origin xyz="0.03 0.035 0.08"/>
    <axis xyz="0 0 1"/><limit lower="-0.5" upper="0.5" effort="1" velocity="6"/></joint>
  <joint name="r_pan" type="revolute"><parent link="head"/><child link="r_eye"/><origin xyz="0.03 -0.035 0.08"/>
    <axis xyz="0 0 1"/><limit lower="-0.5" upper="0.5" effort="1" velocity="6"/></joint>
  <joint name="l_fixed" type="fixed"><parent link="l_eye"/><child link="l_cam"/><origin xyz="0.01 0 0" rpy="0.2 0 0"/></joint>
  <joint name="r_fixed" type="fixed"><parent link="r_eye"/><child link="r_cam"/><origin xyz="0.01 0 0" rpy="0 0.1 0"/></joint>
</robot>
)";
const std::string two_eyes_head =
    "{urdf: two_eyes.urdf, chain: [torso_yaw, nod, turn, l_pan, r_pan], camera: l_cam, right_camera: r_cam, "
    "camera_axes: body, joints: {torso_yaw: {role: torso}, turn: {min_deg: -60, max_deg: 50}}}";

TEST(ModelHead, AChainFromAUrdfIsThatOfTheFile) {
  const TempFolder folder;
  folder.write("two_eyes.urdf", two_eyes);
  const auto head = head_with(folder, two_eyes_head);
  EXPECT_EQ(head->name, "two_eyes");
  ASSERT_EQ(head->joints.size(), 5U);
  EXPECT_EQ(head->torso_joints(), 1);
  EXPECT_EQ(head->neck_joints(), 2);
  EXPECT_NEAR(head->joints[0].min_rad, -0.7, 1e-12);
  EXPECT_NEAR(head->joints[2].max_rad, 50 * rad_per_deg, 1e-12);
  EXPECT_NEAR(head->joints[2].max_speed_rad_s, 2.5, 1e-12);
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(two_eyes.c_str()));
  for (const Eye eye : {Eye::left, Eye::right}) {
    const std::string link = eye == Eye::left ? "l_cam" : "r_cam";
    EXPECT_LT(largest_error(*head, eye, half_turn, body_camera,
                            [&](const Positions& q) { return urdf_pose(document.child("robot"), link, q); }),
              1e-9)
        << link;
  }
}

TEST(ModelHead, TheResolvedScenarioHoldsTheChainItself) {
  const TempFolder folder, elsewhere;
  folder.write("two_eyes.urdf", two_eyes);
  const Scenario scenario = scenario_with(folder, two_eyes_head);
  const std::string resolved = resolved_scenario(scenario);
  EXPECT_EQ(resolved.find("urdf"), std::string::npos);
  const Scenario again = read_scenario(elsewhere.write("a.yaml", resolved), {}, std::nullopt, built_in());
  EXPECT_EQ(resolved_scenario(again), resolved);
}

TEST(ModelHead, ABaseAndItsAxesAreTheRoot) {
  const TempFolder folder;
  folder.write("two_eyes.urdf", two_eyes);
  const auto head = head_with(
      folder,
      "{urdf: two_eyes.urdf, base: mount, chain: [nod, turn], camera: l_cam, camera_axes: body, forward: x, "
      "up: z, joints: {turn: {min_deg: -60, max_deg: 50}}}");
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(two_eyes.c_str()));
  const pugi::xml_node robot = document.child("robot");
  robot.find_child_by_attribute("joint", "name", "mounting")
      .parent()
      .remove_child(robot.find_child_by_attribute("joint", "name", "mounting"));
  EXPECT_LT(largest_error(*head, Eye::left, half_turn, body_camera,
                          [&](const Positions& q) { return urdf_pose(robot, "l_cam", q); }),
            1e-9);
  for (const char* axes : {"forward: y, up: -y", "forward: x, up: w"}) {
    EXPECT_THAT(complaint_about(
                    folder, std::string("{urdf: two_eyes.urdf, chain: [nod], camera: l_cam, ") + axes + "}"),
                HasSubstr("head.up: found"))
        << axes;
  }
}

TEST(ModelHead, WhatIsWrongWithAUrdfIsSaidWithLineAndElement) {
  const TempFolder folder;
  const auto with = [&](const std::string& from, const std::string& to, std::string head = two_eyes_head) {
    std::string text = two_eyes;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    folder.write("two_eyes.urdf", text);
    return complaint_about(folder, head);
  };
  EXPECT_EQ(with("", ""), "nothing");
  EXPECT_THAT(with("</robot>", "</robt>"), HasSubstr("two_eyes.urdf:24: found"));
  EXPECT_THAT(with("<robot name=\"two_eyes\">", "<robot><xacro:include filename=\"a\"/>"),
              AllOf(HasSubstr("two_eyes.urdf:2: <xacro:include>"), HasSubstr("without macros")));
  EXPECT_THAT(with("<link name=\"arm\"/>", ""), HasSubstr("two_eyes.urdf:12: <child>: found arm, expected a "
                                                          "link of the file as the child of joint shoulder"));
  EXPECT_THAT(with("<link name=\"arm\"/>", "<link name=\"head\"/>"),
              HasSubstr("two_eyes.urdf:4: <link name=\"head\">: found a name that is taken"));
  EXPECT_THAT(with("<child link=\"arm\"/>", "<child link=\"head\"/>"),
              HasSubstr("a second parent of link head"));
  EXPECT_THAT(with("name=\"nod\" type=\"revolute\"", "name=\"nod\" type=\"prismatic\""),
              HasSubstr("two_eyes.urdf:13: <joint name=\"nod\">: found type=\"prismatic\", expected revolute "
                        "or continuous"));
  EXPECT_THAT(with("<axis xyz=\"0 1 0.2\"/>", "<axis xyz=\"0 1\"/>"),
              HasSubstr("two_eyes.urdf:14: <axis>: found xyz=\"0 1\", expected three finite numbers"));
  EXPECT_THAT(with("<axis xyz=\"0 1 0.2\"/>", "<axis xyz=\"0 nan 1\"/>"), HasSubstr("three finite numbers"));
  EXPECT_THAT(
      with("<axis xyz=\"0 1 0.2\"/>", "<axis xyz=\"0 1e200 1e200\"/>"),
      HasSubstr(
          "two_eyes.urdf:14: <axis>: found xyz=\"0 1e200 1e200\", expected three finite numbers up to 1e6"));
  EXPECT_THAT(with("<axis xyz=\"0 1 0.2\"/>", "<axis xyz=\"0 0 0\"/>"),
              HasSubstr("<axis>: found an axis of length 0"));
  EXPECT_THAT(with("xyz=\"0 0 0.06\"", "xyz=\"0 0 6e\""), HasSubstr("<origin>: found xyz=\"0 0 6e\""));
  EXPECT_THAT(with("lower=\"-0.5\" upper=\"0.4\"", "lower=\"0.5\" upper=\"0.4\""),
              HasSubstr("two_eyes.urdf:15: <limit>: found lower and upper of joint nod"));
  EXPECT_THAT(with("lower=\"-0.5\" upper=\"0.4\"", "lower=\"0.2\" upper=\"0.4\""),
              HasSubstr("head.joints.nod.min_deg: found 11.4"));
  EXPECT_THAT(with("<axis xyz=\"0 1 0.2\"/>", "<axis xyz=\"0 1 0.2\"/><mimic joint=\"turn\"/>"),
              HasSubstr("<joint name=\"nod\">: found a joint that mimics turn"));
  EXPECT_THAT(with("<joint name=\"lift\" type=\"prismatic\">",
                   "<joint name=\"lift\" type=\"revolute\"><mimic joint=\"nod\"/>"),
              HasSubstr("two_eyes.urdf:5: <joint name=\"lift\">: found a joint that mimics nod"));
  EXPECT_THAT(with("velocity=\"2\"", "velocity=\"0\""),
              HasSubstr("<joint name=\"nod\"> without a speed, expected joints.nod.max_speed_deg_s"));
  EXPECT_THAT(with("velocity=\"2\"", "velocity=\"1e9\""), HasSubstr("without a speed"));
  EXPECT_THAT(with("<limit effort=\"1\" velocity=\"2.5\"/>", ""),
              HasSubstr("two_eyes.urdf:16: <joint name=\"turn\"> without a speed, expected"));
  // A chain that closes on itself, away from the root.
  EXPECT_THAT(with("<parent link=\"base\"/><child link=\"waist\"/>",
                   "<parent link=\"l_cam\"/><child link=\"waist\"/>"),
              HasSubstr("a chain of joints that closes on itself"));
}

TEST(ModelHead, WhatIsWrongWithTheKeysOfAChainIsSaid) {
  const TempFolder folder;
  folder.write("two_eyes.urdf", two_eyes);
  const auto with = [&](const std::string& keys) {
    return complaint_about(
        folder, "{urdf: two_eyes.urdf, joints: {turn: {min_deg: -60, max_deg: 50}}, " + keys + "}");
  };
  EXPECT_EQ(with("chain: [nod, turn], camera: l_cam, camera_axes: body"), "nothing");
  EXPECT_THAT(
      with("chain: [turn, nod], camera: l_cam, camera_axes: body"),
      HasSubstr(
          "found head.chain in another order, expected that from the base to the cameras: [nod, turn]"));
  EXPECT_THAT(with("chain: [nod, turn, shoulder], camera: l_cam"),
              HasSubstr("two_eyes.urdf:12: <joint name=\"shoulder\">: found a joint of head.chain that does "
                        "not turn the camera"));
  EXPECT_THAT(with("chain: [nod, chin], camera: l_cam"),
              HasSubstr("found head.chain: chin, expected the name of a joint"));
  EXPECT_THAT(with("chain: [nod, turn], camera: nose"),
              HasSubstr("found head.camera: nose, expected the name of a link"));
  EXPECT_THAT(with("chain: [nod, turn], camera: l_cam, base: arm"),
              HasSubstr("expected a link on head.base, arm"));
  EXPECT_THAT(with("chain: [nod, turn], camera: l_cam"),
              HasSubstr("head.camera: found an optical axis 81 deg"));  // up, not forward
  EXPECT_THAT(with("chain: [nod, turn], camera: l_cam, camera_axes: side"),
              HasSubstr("expected one of optical, body"));
  EXPECT_THAT(with("chain: nod, camera: l_cam"),
              HasSubstr("head.chain: found nod, expected a list of names"));
  EXPECT_THAT(with("chain: [nod, nod], camera: l_cam"),
              HasSubstr("head.chain: found a list, expected a list of names, each once"));
  EXPECT_THAT(with("camera: l_cam"), HasSubstr("found no chain"));
  EXPECT_THAT(with("chain: [nod]"), HasSubstr("found no camera"));
  EXPECT_THAT(complaint_about(folder, "{chain: [nod], camera: l_cam}"),
              HasSubstr("head.chain: found no model, expected urdf or mjcf"));
  EXPECT_THAT(complaint_about(folder, "{urdf: nowhere.urdf, chain: [nod], camera: l_cam}"),
              HasSubstr("nowhere.urdf: expected a readable file of XML"));
}

/// A pan-tilt unit on a post, with ranges from a default, an anchor beside the body, and a camera that MuJoCo turns by xyaxes.
const std::string post = R"(<mujoco model="post">
  <compiler angle="degree" autolimits="true"/>
  <default><joint range="-50 40"/></default>
  <worldbody>
    <body name="post" pos="0.02 0.01 0.3" axisangle="1 2 3 4">
      <body name="pan_body" pos="0 0.01 0.05">
        <joint name="pan" axis="0.1 0 1" pos="0.01 0.02 0.03"/>
        <geom size="0.01"/>
        <body name="tilt_body" pos="0.02 0 0.04" axisangle="0 1 0 5">
          <joint name="tilt" axis="0 -1 0"/>
          <joint name="slide" type="slide" axis="0 0 1"/>
          <geom size="0.01"/>
          <camera name="eye" pos="0.03 0 0.01" axisangle="1 -1 -1 120"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
)";
const std::string post_head =
    "{mjcf: post.xml, chain: [pan, tilt], camera: eye, joints: {pan: {max_speed_deg_s: 90}, tilt: "
    "{max_speed_deg_s: 80, role: eye}}}";

TEST(ModelHead, AChainFromAnMjcfIsThatOfTheFile) {
  const TempFolder folder;
  folder.write("post.xml", post);
  const Scenario scenario = scenario_with(folder, post_head);
  EXPECT_EQ(scenario.sim.world.head.description.mjcf, "");
  const auto head = head_model(scenario.sim.world.head);
  ASSERT_EQ(head->joints.size(), 2U);
  EXPECT_NEAR(head->joints[0].min_rad, -50 * rad_per_deg, 1e-12);
  EXPECT_NEAR(head->joints[1].max_rad, 40 * rad_per_deg, 1e-12);
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(post.c_str()));
  const pugi::xml_node camera = document.select_node("//camera").node();
  EXPECT_LT(largest_error(*head, Eye::left, half_turn, mujoco_camera,
                          [&](const Positions& q) { return mjcf_pose(camera, q); }),
            1e-9);
  const auto by_body =
      head_with(folder,
                "{mjcf: post.xml, chain: [pan, tilt], camera: tilt_body, camera_axes: body, joints: "
                "{pan: {max_speed_deg_s: 90}, tilt: {max_speed_deg_s: 80}}}");
  EXPECT_LT(largest_error(*by_body, Eye::left, half_turn, body_camera,
                          [&](const Positions& q) { return mjcf_pose(camera.parent(), q); }),
            1e-9);
}

TEST(ModelHead, WhatIsWrongWithAnMjcfIsSaidWithItsElement) {
  const TempFolder folder;
  const auto with = [&](const std::string& from, const std::string& to, std::string head = post_head) {
    std::string text = post;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    folder.write("post.xml", text);
    return complaint_about(folder, head);
  };
  EXPECT_EQ(with("", ""), "nothing");
  EXPECT_THAT(with("<geom size", "<gem size"), AllOf(HasSubstr("post.xml: found"), HasSubstr("line 8")));
  EXPECT_THAT(with("name=\"pan\"", "name=\"pan\" type=\"slide\""),
              HasSubstr("post.xml:7: <joint name=\"pan\">: found a joint that is no hinge"));
  EXPECT_THAT(with("range=\"-50 40\"", ""), HasSubstr("post.xml:7: <joint name=\"pan\"> without limits; "));
  EXPECT_THAT(with("", "", "{mjcf: post.xml, chain: [pan, tilt], camera: eye}"),
              HasSubstr("<joint name=\"tilt\"> without a speed, expected joints.pan.max_speed_deg_s, "
                        "joints.tilt.max_speed_deg_s"));
  EXPECT_THAT(
      with("</worldbody>", "</worldbody><equality><joint joint1=\"tilt\" joint2=\"pan\"/></equality>"),
      HasSubstr("post.xml:10: <joint name=\"tilt\">: found a joint that follows another"));
  EXPECT_THAT(
      with("</worldbody>", "</worldbody><equality><joint joint1=\"slide\" joint2=\"pan\"/></equality>"),
      HasSubstr("post.xml:11: <joint name=\"slide\">: found a joint that follows pan"));
  EXPECT_THAT(with("name=\"eye\"", "name=\"eye\" mode=\"targetbody\" target=\"post\""),
              HasSubstr("post.xml:13: <camera name=\"eye\">: found a camera that turns to a target"));
  EXPECT_THAT(with("", "", "{mjcf: post.xml, chain: [pan, tilt], camera: nose}"),
              HasSubstr("head.camera: nose"));
  EXPECT_THAT(with("", "", "{mjcf: post.xml, chain: [tilt, pan], camera: eye}"), HasSubstr("[pan, tilt]"));
  EXPECT_THAT(with("", "", "{mjcf: post.xml, base: pan_body, chain: [pan, tilt], camera: eye}"),
              HasSubstr("<joint name=\"pan\">: found a joint of head.chain that does not turn the camera"));
  EXPECT_THAT(with("", "", "{mjcf: none.xml, chain: [pan], camera: eye}"), HasSubstr("none.xml"));
}

/// The chain of the ergoCub as published, to 5 decimals.
const std::string rounded_ergocub = R"(<robot name="r"><link name="a"/>
  <joint name="torso_roll"><parent link="a"/><child link="b"/><origin xyz="0 0 .0605"/><axis xyz="-1 0 0"/></joint>
  <joint name="torso_pitch"><parent link="b"/><child link="c"/><origin xyz="0 0 .118"/><axis xyz="0 1 0"/></joint>
  <joint name="torso_yaw"><parent link="c"/><child link="d"/><origin xyz="0 0 .06447"/><axis xyz="0 0 -1"/></joint>
  <joint name="neck_pitch"><parent link="d"/><child link="e"/><origin xyz=".00486 0 .2253"/><axis xyz="0 -1 0"/></joint>
  <joint name="neck_roll"><parent link="e"/><child link="f"/><origin xyz="0 0 .0095"/><axis xyz="1 0 0"/></joint>
  <joint name="neck_yaw"><parent link="f"/><child link="g"/><origin xyz="0 0 .06915"/><axis xyz="0 0 1"/></joint>
  <joint name="camera_tilt"><parent link="g"/><child link="h"/><origin xyz=".06251 -.00003 .07639" rpy="0 .00026 0"/>
    <axis xyz="0 -1 0"/></joint>
  <joint name="camera"><parent link="h"/><child link="realsense_rgb_frame"/><origin xyz=".00752 -.0115 0"
    rpy="-1.57079632679 0 -1.57079632679"/></joint></robot>)";

TEST(ModelHead, TheErgocubHasItsPublishedChain) {
  HeadConfig config;
  config.model = HeadKind::ergocub;
  config.version = "SN001";
  const auto head = head_model(config);
  EXPECT_EQ(head->name, "ergocub SN001");
  EXPECT_EQ(head->torso_joints(), 3);
  EXPECT_EQ(head->gaze_joints(), 4);
  EXPECT_EQ(head->chain.eyes, 1);
  EXPECT_FALSE(head->has_icub_gaze());
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(rounded_ergocub.c_str()));
  const auto pose = [&](const Positions& q) {
    return urdf_pose(document.child("robot"), "realsense_rgb_frame", q);
  };
  // 8 places rounded to 5e-6 m each, and an angle to 1e-6 rad.
  EXPECT_LT(largest_error(*head, Eye::left, half_turn, no_turn, pose), 5e-5);
}

TEST(ModelHead, TheErgocubHasTheChainAndLimitsOfItsUrdf) {
  const char* const folder = std::getenv("SACCADE_ERGOCUB_SOFTWARE");
  if (folder == nullptr) GTEST_SKIP() << "SACCADE_ERGOCUB_SOFTWARE is not set to a clone of ergocub-software";
  for (const std::string& version : ergocub_versions()) {
    const fs::path path = fs::path(folder) / "urdf/ergoCub/robots" / ("ergoCub" + version) / "model.urdf";
    pugi::xml_document document;
    ASSERT_TRUE(document.load_file(path.c_str())) << path;
    const pugi::xml_node robot = document.child("robot");
    const auto pose = [&](const Positions& q) { return urdf_pose(robot, "realsense_rgb_frame", q); };
    HeadConfig config;
    config.model = HeadKind::ergocub;
    config.version = version;
    const auto head = head_model(config);
    const double error = largest_error(*head, Eye::left, half_turn, no_turn, pose);
    std::cout << version << ": " << error << " m\n";
    EXPECT_LT(error, 1e-9) << version;
    ChainRequest request;
    request.path = path.string();
    for (const HeadJoint& joint : head->joints) {
      request.joints.push_back(joint.name);
      const pugi::xml_node limit =
          robot.find_child_by_attribute("joint", "name", joint.name.c_str()).child("limit");
      EXPECT_NEAR(limit.attribute("lower").as_double(), joint.min_rad, 1e-12) << joint.name;
      EXPECT_NEAR(limit.attribute("upper").as_double(), joint.max_rad, 1e-12) << joint.name;
    }
    request.camera = "realsense_rgb_frame";
    request.root_from_base = *root_from_axes("x", "z");
    HeadDescription read = description_of(chain_of_urdf(request), "read");
    for (auto& [name, joint] : read.joints) joint.max_speed_deg_s = 50.0;  // 1e9 in the file
    EXPECT_LT(largest_error(*described_head(read), Eye::left, half_turn, no_turn, pose), 1e-9) << version;
  }
}

TEST(ModelHead, TheErgocubIsAModelWithVersionsOfItsOwn) {
  const TempFolder folder;
  EXPECT_EQ(head_with(folder, "{model: ergocub}")->name, "ergocub SN001");
  EXPECT_EQ(head_with(folder, "{model: ergocub, version: SN003}")->name, "ergocub SN003");
  EXPECT_THAT(complaint_about(folder, "{model: ergocub, version: 2.10}"),
              HasSubstr("head.version: found 2.10, expected one of SN001, SN003"));
  EXPECT_THAT(complaint_about(folder, "{version: SN003}"),
              HasSubstr("head.version: found SN003, expected one of 1, 2"));
  const Scenario scenario = scenario_with(folder, "{model: ergocub, version: SN003}");
  const std::string resolved = resolved_scenario(scenario);
  EXPECT_EQ(resolved_scenario(read_scenario(folder.write("a.yaml", resolved), {}, std::nullopt, built_in())),
            resolved);
}

TEST(ModelHead, DirectionsAreThoseOfTheRoot) {
  const auto same = root_from_axes("-x", "z");  // the root's own axes
  ASSERT_TRUE(same.has_value());
  EXPECT_TRUE(same->isIdentity(0.0));
  EXPECT_NEAR(root_from_axes("y", "-x")->determinant(), 1.0, 1e-15);
  EXPECT_FALSE(root_from_axes("x", "-x").has_value());
  EXPECT_FALSE(root_from_axes("forward", "z").has_value());
}

}  // namespace
}  // namespace saccade
