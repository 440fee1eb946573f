#include "head/head_model.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/error.h"

namespace saccade {

int HeadModel::count(JointRole role) const {
  return static_cast<int>(std::count_if(joints.begin(), joints.end(),
                                        [role](const HeadJoint& joint) { return joint.role == role; }));
}

std::string_view HeadModel::name_of(int slot) const {
  for (const HeadJoint& joint : joints) {
    if (joint.slot == slot) return joint.name;
  }
  return {};
}

Eigen::VectorXd HeadModel::in_order(const JointVector& by_slot) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t i = 0; i < joints.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = by_slot[joints[i].slot];
  return values;
}

Eigen::VectorXd HeadModel::gaze_in_order(const HeadJointVector& by_slot) const {
  return by_slot.head(gaze_joints());
}

JointVector HeadModel::by_slot(const Eigen::VectorXd& in_order) const {
  JointVector values = JointVector::Zero();
  for (std::size_t i = 0; i < joints.size(); ++i)
    values[joints[i].slot] = in_order[static_cast<Eigen::Index>(i)];
  return values;
}

HeadJointVector HeadModel::gaze_by_slot(const Eigen::VectorXd& in_order) const {
  HeadJointVector values = HeadJointVector::Zero();
  values.head(gaze_joints()) = in_order;
  return values;
}

std::shared_ptr<const HeadModel> aiming_cameras(const std::shared_ptr<const HeadModel>& head,
                                                const Eigen::Isometry3d& left_eye_from_camera,
                                                const Eigen::Isometry3d& right_eye_from_camera) {
  const Eigen::Matrix4d none = Eigen::Matrix4d::Identity();
  if (left_eye_from_camera.matrix() == none && right_eye_from_camera.matrix() == none) return head;
  auto aiming = std::make_shared<HeadModel>(*head);
  const std::array<const Eigen::Isometry3d*, 2> mounts = {&left_eye_from_camera, &right_eye_from_camera};
  for (std::size_t e = 0; e < mounts.size(); ++e) {
    Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
    turned.translation() = mounts[e]->translation();
    turned.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), mounts[e]->linear().col(2))
                          .toRotationMatrix();
    aiming->chain.eye_from_last[e] = aiming->chain.eye_from_last[e] * turned;
  }
  aiming->chain.has_eye_from_last = true;
  return aiming;
}

std::shared_ptr<const HeadModel> head_of_names(const std::vector<std::string>& names) {
  const auto same = [](const std::string& name, const HeadJoint& joint) { return name == joint.name; };
  if (std::equal(names.begin(), names.end(), default_head()->joints.begin(), default_head()->joints.end(),
                 same))
    return default_head();
  SACCADE_CHECK(names.size() <= gaze_slots);
  auto head = std::make_shared<HeadModel>();
  head->name = "head of a table";
  for (const std::string& name : names) {
    head->joints.push_back({name, JointRole::neck, torso_slots + static_cast<int>(head->joints.size())});
  }
  return head;
}

bool HeadModel::has_icub_gaze() const {
  if (neck_joints() != neck_joint_count || gaze_joints() != eyes_vergence + 1 - torso_slots ||
      chain.eyes != 2)
    return false;
  // Tilt turns both eyes together, version both pans alike, vergence them against each other.
  if (chain.common.empty() || chain.common.back().joints != 1 ||
      chain.common.back().turns[0].slot != eyes_tilt)
    return false;
  for (const std::size_t e : {std::size_t{0}, std::size_t{1}}) {
    if (chain.eye[e].size() != 1 || chain.eye[e][0].joints != 2) return false;
    const auto& [version, vergence] = chain.eye[e][0].turns;
    if (version.slot != eyes_version || version.share != 1.0 || vergence.slot != eyes_vergence ||
        vergence.share != (e == 0 ? 0.5 : -0.5))
      return false;
  }
  return true;
}

}  // namespace saccade
