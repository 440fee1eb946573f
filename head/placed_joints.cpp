#include "head/placed_joints.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace saccade {
namespace {

void add(const PlacedJoint& joint, HeadDescription& head, DescribedLinks& links) {
  DescribedJoint described;
  described.role = joint.role;
  described.min_deg = joint.min_rad / rad_per_deg;
  described.max_deg = joint.max_rad / rad_per_deg;
  described.max_speed_deg_s = joint.max_speed_rad_s / rad_per_deg;
  head.joints.emplace_back(joint.name, described);
  DescribedLink link;
  link.kind = LinkKind::axis;
  link.axis = joint.axis;
  link.point_m = joint.point_m;
  link.joint = joint.name;
  links.emplace_back(joint.name, link);
}

DescribedPose pose_of(const Eigen::Isometry3d& camera) {
  return {camera.translation(), camera.linear().col(2), -camera.linear().col(1)};
}

std::optional<Eigen::Vector3d> direction(std::string_view word) {
  const bool negative = word.starts_with('-');
  if (negative) word.remove_prefix(1);
  if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') return std::nullopt;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  axis[word[0] - 'x'] = negative ? -1.0 : 1.0;
  return axis;
}

}  // namespace

HeadDescription description_of(const PlacedChain& chain, const std::string& name) {
  HeadDescription head;
  head.name = name;
  for (const PlacedJoint& joint : chain.common) add(joint, head, head.links);
  for (const PlacedJoint& joint : chain.eye[0]) add(joint, head, head.left_eye.links);
  head.left_eye.pose = pose_of(chain.root_from_camera[0]);
  if (chain.cameras > 1) {
    head.right_eye.emplace();
    for (const PlacedJoint& joint : chain.eye[1]) add(joint, head, head.right_eye->links);
    head.right_eye->pose = pose_of(chain.root_from_camera[1]);
  }
  return head;
}

std::optional<Eigen::Matrix3d> root_from_axes(std::string_view forward, std::string_view up) {
  const auto ahead = direction(forward), above = direction(up);
  if (!ahead || !above || std::abs(ahead->dot(*above)) > 0.5) return std::nullopt;
  Eigen::Matrix3d root_from_base;  // its rows are the root's axes
  root_from_base << -ahead->transpose(), above->cross(-*ahead).transpose(), above->transpose();
  return root_from_base;
}

Eigen::Matrix3d body_from_optical() {
  Eigen::Matrix3d rotation;
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return rotation;
}

double degrees_from_forward(const Eigen::Isometry3d& root_from_camera) {
  return std::acos(std::clamp(-root_from_camera.linear()(0, 2), -1.0, 1.0)) / rad_per_deg;
}

}  // namespace saccade
