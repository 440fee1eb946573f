#include "sim/head_mjcf.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "sim/described_head.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) throw InputError(path.string(), "", "a readable MJCF file");
  return text.str();
}

/// An element of an MJCF text.
struct Element {
  std::size_t begin;
  std::size_t end;  // of its opening tag
};

Element element_at(const std::string& text, std::size_t begin) {
  SACCADE_CHECK(begin != std::string::npos);
  const std::size_t end = text.find('>', begin);
  SACCADE_CHECK(end != std::string::npos);
  return {begin, end};
}

/// Sets an attribute of the opening tag at `begin`, which is added where it is missing.
void set_attribute(std::string& text, std::size_t begin, const std::string& name, const std::string& value) {
  const Element tag = element_at(text, begin);
  const std::size_t found = text.find(" " + name + "=\"", tag.begin);
  if (found == std::string::npos || found > tag.end) {
    const std::size_t name_end = text.find_first_of(" />", tag.begin + 1);
    text.insert(name_end, " " + name + "=\"" + value + "\"");
    return;
  }
  const std::size_t open = found + name.size() + 3;
  text.replace(open, text.find('"', open) - open, value);
}

/// icub_head.xml with the chain of another version. Its bodies are parallel to the root frame at zero, each at a point of
/// its hinge's axis.
std::string with_chain(std::string text, const HeadModel& head) {
  constexpr std::array<const char*, 9> bodies = {"torso_1", "torso_2", "chest", "neck_1", "neck_2",
                                                 "head",    "eyes",    "l_eye", "r_eye"};
  const Hinges at_zero = hinges_at_zero(head.chain);
  SACCADE_CHECK(at_zero.hinges.size() == bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Hinge& hinge = at_zero.hinges[i];
    const Eigen::Vector3d parent_m =
        hinge.parent == Hinge::none ? Eigen::Vector3d::Zero() : at_zero.hinges[hinge.parent].point_m;
    const std::size_t body = text.find("<body name=\"" + std::string(bodies[i]) + "\"");
    set_attribute(text, body, "pos", mjcf_numbers(hinge.point_m - parent_m));
    const std::size_t joint = text.find("<joint name=", body);
    set_attribute(text, joint, "name", hinge.link->name);
    set_attribute(text, joint, "axis", mjcf_numbers(hinge.axis));
    if (hinge.link->joints == 1) {
      for (const HeadJoint& limits : head.joints) {
        if (limits.slot != hinge.link->turns[0].slot) continue;
        set_attribute(text, joint, "range",
                      mjcf_numbers(limits.min_rad) + " " + mjcf_numbers(limits.max_rad));
      }
    }
    if (i < 7) continue;
    const std::size_t e = i - 7;
    const std::size_t camera = text.find("<camera name=\"" + std::string(eye_camera_names[e]) + "\"");
    set_attribute(text, camera, "pos", mjcf_numbers(at_zero.root_from_eye[e].translation() - hinge.point_m));
  }
  return text;
}

int find_named(const mjModel& model, mjtObj type, const std::string& name, const std::string& model_name) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id < 0) {
    throw InputError(model_name, "no " + std::string(mju_type2Str(type)) + " " + name,
                     "one: the head's description has it");
  }
  return id;
}

/// The pose of a camera with the axes of OpenCV.
Eigen::Isometry3d camera_pose(const mjData& data, int camera) {
  using RowMajor = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d rotation = Eigen::Map<const RowMajor>(data.cam_xmat + 9 * camera);
  rotation.rightCols<2>() *= -1.0;
  pose.linear() = rotation;
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(data.cam_xpos + 3 * camera);
  return pose;
}

std::array<Eigen::Isometry3d, 2> eyes_at(const HeadChain& chain, const JointVector& q) {
  const auto pass = [&q](const std::vector<ChainLink>& links, Eigen::Isometry3d frame) {
    for (const ChainLink& link : links) {
      apply_before(link, frame);
      apply_turn(link, link.angle_rad(q), frame);
    }
    return frame;
  };
  const Eigen::Isometry3d head = pass(chain.common, chain.root_from_base);
  std::array<Eigen::Isometry3d, 2> eyes;
  for (std::size_t e = 0; e < 2; ++e) eyes[e] = pass(chain.eye[e], head) * chain.eye_from_last[e];
  return eyes;
}

void check_chain(const HeadModel& head, const mjModel& model, const std::vector<HeadMotor>& motors,
                 const std::string& model_name) {
  constexpr int poses = 5;
  constexpr double tolerance = 1e-9;
  const MotorCoupling coupling(head);
  const MjDataPtr data(mj_makeData(&model));
  if (!data) throw RunError("MuJoCo has no memory to check the head");
  for (int i = 0; i < poses; ++i) {
    JointVector q = JointVector::Zero();
    for (std::size_t j = 0; i > 0 && j < head.joints.size(); ++j) {
      q[head.joints[j].slot] = 0.3 * std::sin(1.7 * i + 2.3 * static_cast<double>(j));
    }
    const JointVector motor_rad = coupling.motors_from_joints(q);
    for (std::size_t m = 0; m < motors.size(); ++m) {
      data->qpos[model.jnt_qposadr[motors[m].joint]] = motor_rad[static_cast<Eigen::Index>(m)];
    }
    mj_kinematics(&model, data.get());
    mj_camlight(&model, data.get());
    const auto eyes = eyes_at(head.chain, q);
    for (std::size_t e = 0; e < static_cast<std::size_t>(head.chain.eyes); ++e) {
      const int camera = find_named(model, mjOBJ_CAMERA, eye_camera_names[e], model_name);
      const Eigen::Isometry3d found = camera_pose(*data, camera);
      const double apart_m = (found.translation() - eyes[e].translation()).norm();
      const double turned = (found.linear() - eyes[e].linear()).norm();
      if (apart_m < tolerance && turned < tolerance) continue;
      char text[120];
      std::snprintf(text, sizeof text, "camera %s %.3g mm and %.3g deg beside the description's eye",
                    eye_camera_names[e], 1e3 * apart_m, turned / std::sqrt(2.0) * 180.0 / 3.141592653589793);
      throw InputError(model_name, text, "the chain of " + head.name);
    }
  }
}

}  // namespace

std::string mjcf_numbers(std::span<const double> values) {
  std::string text;
  for (const double value : values) {
    constexpr double finest = 1e-15;  // rounding of sums
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.15g", std::abs(value) < finest ? 0.0 : value);
    text += (text.empty() ? "" : " ") + std::string(digits.data());
  }
  return text;
}

std::string mjcf_numbers(const Eigen::Vector3d& v) { return mjcf_numbers(std::span(v.data(), 3)); }
std::string mjcf_numbers(double value) { return mjcf_numbers(std::span(&value, 1)); }

std::string head_mjcf(const HeadModel& head, const std::filesystem::path& models) {
  if (!head.mjcf.empty()) return text_of_file(head.mjcf);
  if (!head.is_icub) return described_head_mjcf(head);
  const std::string icub = text_of_file(models / "icub_head.xml");
  return head.name == default_head()->name ? icub : with_chain(icub, head);
}

std::vector<HeadMotor> find_motors(const HeadModel& head, const mjModel& model,
                                   const std::string& model_name) {
  std::vector<HeadMotor> motors;
  for (const Hinge& hinge : hinges_at_zero(head.chain).hinges) {
    HeadMotor& motor = motors.emplace_back();
    motor.joint = find_named(model, mjOBJ_JOINT, hinge.link->name, model_name);
    motor.actuator = find_named(model, mjOBJ_ACTUATOR, hinge.link->name, model_name);
    for (const HeadJoint& joint : head.joints) {
      if (joint.slot == hinge.link->turns[0].slot) motor.role = joint.role;
    }
  }
  check_chain(head, model, motors, model_name);
  return motors;
}

MotorCoupling::MotorCoupling(const HeadModel& head) {
  const Hinges at_zero = hinges_at_zero(head.chain);
  const auto motors = static_cast<Eigen::Index>(at_zero.hinges.size());
  const auto joints = static_cast<Eigen::Index>(head.joints.size());
  SACCADE_CHECK(motors <= joint_slots);
  Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(motors, joints);
  for (Eigen::Index m = 0; m < motors; ++m) {
    const ChainLink& link = *at_zero.hinges[static_cast<std::size_t>(m)].link;
    for (int i = 0; i < link.joints; ++i) {
      const JointShare& by = link.turns[static_cast<std::size_t>(i)];
      motor_terms_.push_back({static_cast<int>(m), by.slot, by.share});
      for (Eigen::Index j = 0; j < joints; ++j) {
        if (head.joints[static_cast<std::size_t>(j)].slot == by.slot) shares(m, j) = by.share;
      }
    }
  }
  // The joints are those that fit the motors best; exactly where there are as many.
  const Eigen::MatrixXd inverse = (shares.transpose() * shares).inverse() * shares.transpose();
  for (Eigen::Index j = 0; j < joints; ++j) {
    for (Eigen::Index m = 0; m < motors; ++m) {
      if (inverse(j, m) == 0.0) continue;
      joint_terms_.push_back(
          {head.joints[static_cast<std::size_t>(j)].slot, static_cast<int>(m), inverse(j, m)});
    }
  }
}

JointVector MotorCoupling::motors_from_joints(const JointVector& by_slot) const {
  JointVector motors = JointVector::Zero();
  for (const Term& term : motor_terms_) motors[term.to] += term.share * by_slot[term.from];
  return motors;
}

JointVector MotorCoupling::joints_from_motors(const JointVector& motors) const {
  JointVector by_slot = JointVector::Zero();
  for (const Term& term : joint_terms_) by_slot[term.to] += term.share * motors[term.from];
  return by_slot;
}

}  // namespace saccade
