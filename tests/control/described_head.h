#pragma once

#include "head/head_description.h"
#include "head/head_model.h"

namespace saccade {

inline DescribedLink axis_link(const Eigen::Vector3d& axis, const Eigen::Vector3d& point_m,
                               const std::string& joint) {
  DescribedLink link;
  link.kind = LinkKind::axis;
  link.axis = axis;
  link.point_m = point_m;
  link.joint = joint;
  return link;
}

/// A pan-tilt unit with one camera, by its axes.
inline HeadDescription pan_tilt() {
  HeadDescription head;
  head.name = "pan-tilt unit";
  head.joints = {{"pan", {JointRole::eye, -90, 90, 240, 6}}, {"tilt", {JointRole::eye, -60, 60, 240, 6}}};
  head.links = {{"pan", axis_link({0, 0, -1}, {0, 0, 0.29}, "pan")},
                {"tilt", axis_link({0, 1, 0}, {0, 0, 0.335}, "tilt")}};
  head.left_eye.pose = DescribedPose{{-0.02, 0, 0.35}, {-1, 0, 0}, {0, 0, 1}};
  return head;
}

/// A snake of twelve joints, all of them the neck's but the last two, whose axes are rows of a DH table, with two eyes.
inline HeadDescription twelve_joints() {
  HeadDescription head;
  head.name = "twelve joints";
  for (int i = 0; i < 12; ++i) {
    DescribedLink link;
    link.joint = "joint_" + std::to_string(i);
    link.a_m = 0.02;
    link.alpha_deg = i % 2 == 0 ? 90.0 : -90.0;
    head.joints.push_back({link.joint, {i < 10 ? JointRole::neck : JointRole::eye, -40, 40, 200, 10}});
    head.links.emplace_back(link.joint, link);
  }
  head.base_rotation = {0, 0, -1, 1, 0,
                        0, 0, -1, 0};  // z backward of the root's x: the chain goes along the root's y
  head.left_eye.pose = DescribedPose{{-0.1, 0.2, 0.3}, {-1, 0, 0}, {0, 0, 1}};
  head.right_eye.emplace();
  head.right_eye->pose = DescribedPose{{-0.1, 0.26, 0.3}, {-1, 0, 0}, {0, 0, 1}};
  return head;
}

/// The limits of a head's own description.
inline JointLimits limits_of(const std::shared_ptr<const HeadModel>& head) {
  JointLimits limits;
  limits.head = head;
  for (const HeadJoint& joint : head->joints) {
    limits.min_rad[joint.slot] = joint.min_rad;
    limits.max_rad[joint.slot] = joint.max_rad;
    limits.max_speed_rad_s[joint.slot] = joint.max_speed_rad_s;
  }
  return limits;
}

}  // namespace saccade
