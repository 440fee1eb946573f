#include "sim/described_head.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>

#include "core/error.h"
#include "sim/head_mjcf.h"

namespace saccade {
namespace {

constexpr double inertia_kg_m2 =
    1e-2;  // of each motor's rotor behind its gear; a servo's speed does not depend on it

const HeadJoint& joint_of(const HeadModel& head, const ChainLink& link) {
  for (const HeadJoint& joint : head.joints) {
    if (joint.slot == link.turns[0].slot) return joint;
  }
  SACCADE_CHECK(false && "a link is turned by a joint of the head");
  return head.joints.front();
}

/// The range of a hinge: from those of its joints.
std::array<double, 2> range_of(const HeadModel& head, const ChainLink& link) {
  std::array<double, 2> range = {0.0, 0.0};
  for (int i = 0; i < link.joints; ++i) {
    const JointShare& by = link.turns[static_cast<std::size_t>(i)];
    for (const HeadJoint& joint : head.joints) {
      if (joint.slot != by.slot) continue;
      const double a = by.share * joint.min_rad, b = by.share * joint.max_rad;
      range[0] += std::min(a, b);
      range[1] += std::max(a, b);
    }
  }
  return range;
}

std::string geom(const char* type, const std::string& material, double size_m, const Eigen::Vector3d& from_m,
                 const Eigen::Vector3d& to_m) {
  return std::string("<geom class=\"head\" type=\"") + type + "\" material=\"" + material + "\" size=\"" +
         mjcf_numbers(size_m) + "\" fromto=\"" + mjcf_numbers(from_m) + " " + mjcf_numbers(to_m) + "\"/>";
}

class Writer {
 public:
  explicit Writer(const HeadModel& head) : head_(head), at_zero_(hinges_at_zero(head.chain)) {}

  [[nodiscard]] std::string mjcf() const {
    constexpr double floor_m = -0.6;
    const Eigen::Vector3d first_m = at_zero_.hinges.front().point_m;
    const Eigen::Vector3d foot_m(first_m.x(), first_m.y(), std::min(floor_m, first_m.z() - 0.1));
    return R"(<mujoco model="head">
  <compiler angle="radian" autolimits="false"/>
  <option timestep="0.001" integrator="implicit"><flag contact="disable"/></option>
  <default>
    <default class="head">
      <joint type="hinge" limited="true" margin="0.0003" solreflimit="0.002 1" solimplimit="0.99 0.999 0.0001"/>
      <geom contype="0" conaffinity="0" group="2"/>
      <position ctrllimited="false" forcelimited="true"/>
    </default>
  </default>
  <asset>
    <material name="head_metal" rgba="0.42 0.43 0.46 1" specular="0.6" shininess="0.6"/>
    <material name="head_servo" rgba="0.13 0.13 0.14 1" specular="0.2" shininess="0.3"/>
    <material name="head_camera" rgba="0.75 0.12 0.10 1" specular="0.4" shininess="0.5"/>
  </asset>
  <worldbody><body name="root">)" +
           geom("capsule", "head_metal", 0.012, foot_m, first_m) +
           children(Hinge::none, Eigen::Vector3d::Zero()) + "</body></worldbody><actuator>" + servos() +
           "</actuator></mujoco>";
  }

 private:
  [[nodiscard]] std::string children(std::size_t parent, const Eigen::Vector3d& origin_m) const {
    std::string text;
    for (std::size_t i = 0; i < at_zero_.hinges.size(); ++i) {
      if (at_zero_.hinges[i].parent == parent) text += body(i, origin_m);
    }
    for (std::size_t e = 0; e < static_cast<std::size_t>(head_.chain.eyes); ++e) {
      if (at_zero_.last[e] == parent) text += camera(e, origin_m);
    }
    return text;
  }

  [[nodiscard]] std::string body(std::size_t i, const Eigen::Vector3d& origin_m) const {
    const Hinge& hinge = at_zero_.hinges[i];
    const std::string& name = hinge.link->name;
    const HeadJoint& joint = joint_of(head_, *hinge.link);
    const std::array<double, 2> range = range_of(head_, *hinge.link);
    const Eigen::Vector3d offset_m = hinge.point_m - origin_m;
    std::string text = "<body name=\"link_" + name + "\" pos=\"" + mjcf_numbers(offset_m) + "\">";
    text += "<inertial pos=\"0 0 0\" mass=\"1e-4\" diaginertia=\"1e-7 1e-7 1e-7\"/>";
    text += "<joint name=\"" + name + "\" class=\"head\" axis=\"" + mjcf_numbers(hinge.axis) + "\" range=\"" +
            mjcf_numbers(range[0]) + " " + mjcf_numbers(range[1]) + "\" armature=\"" +
            mjcf_numbers(inertia_kg_m2) + "\" damping=\"" + mjcf_numbers(damping(joint)) + "\"/>";
    constexpr double half_servo_m = 0.018;
    text += geom("cylinder", "head_servo", 0.014, -half_servo_m * hinge.axis, half_servo_m * hinge.axis);
    if (hinge.parent != Hinge::none && offset_m.norm() > 1e-3)
      text += geom("capsule", "head_metal", 0.006, -offset_m, Eigen::Vector3d::Zero());
    return text + children(i, hinge.point_m) + "</body>";
  }

  [[nodiscard]] std::string camera(std::size_t e, const Eigen::Vector3d& origin_m) const {
    const Eigen::Isometry3d& eye = at_zero_.root_from_eye[e];
    const Eigen::Vector3d place_m = eye.translation() - origin_m;
    const Eigen::Vector3d right = eye.linear().col(0), up = -eye.linear().col(1), ahead = eye.linear().col(2);
    std::string text = std::string("<camera name=\"") + eye_camera_names[e] + "\" pos=\"" +
                       mjcf_numbers(place_m) + "\" xyaxes=\"" + mjcf_numbers(right) + " " + mjcf_numbers(up) +
                       "\" fovy=\"65.4\"/>";
    text += geom("cylinder", "head_camera", 0.016, place_m - 0.030 * ahead, place_m - 0.002 * ahead);
    if (place_m.norm() > 1e-3) text += geom("capsule", "head_metal", 0.006, Eigen::Vector3d::Zero(), place_m);
    return text;
  }

  [[nodiscard]] std::string servos() const {
    std::string text;
    for (const Hinge& hinge : at_zero_.hinges) {
      const HeadJoint& joint = joint_of(head_, *hinge.link);
      const double omega = natural_rad_s(joint);
      // A servo without force left is a third faster than the limit of the references.
      const double largest_nm = damping(joint) * joint.max_speed_rad_s * fastest_share(*hinge.link) / 0.75;
      text += "<position name=\"" + hinge.link->name + "\" class=\"head\" joint=\"" + hinge.link->name +
              "\" kp=\"" + mjcf_numbers(inertia_kg_m2 * omega * omega) + "\" forcerange=\"" +
              mjcf_numbers(-largest_nm) + " " + mjcf_numbers(largest_nm) + "\"/>";
    }
    return text;
  }

  static double fastest_share(const ChainLink& link) {
    double sum = 0.0;
    for (int i = 0; i < link.joints; ++i) sum += std::abs(link.turns[static_cast<std::size_t>(i)].share);
    return sum;
  }
  /// A critically damped servo follows with -3 dB at 0.644 of its natural frequency.
  static double natural_rad_s(const HeadJoint& joint) {
    return 2.0 * std::numbers::pi * joint.bandwidth_hz / 0.644;
  }
  static double damping(const HeadJoint& joint) { return 2.0 * inertia_kg_m2 * natural_rad_s(joint); }

  const HeadModel& head_;
  Hinges at_zero_;
};

}  // namespace

std::string described_head_mjcf(const HeadModel& head) { return Writer(head).mjcf(); }

}  // namespace saccade
