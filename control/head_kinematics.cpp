#include "control/head_kinematics.h"

#include <Eigen/LU>
#include <cmath>

#include "core/error.h"

namespace saccade {
namespace {

// sin^2 of the smallest angle between optical axes that counts as an intersection: 0.1 deg.
constexpr double min_sine_squared = 3.0462e-6;

/// In the order in which Eigen multiplies a matrix of nine columns, the joints of an iCub, whatever the number of slots.
Eigen::Vector3d velocity_of(const PointJacobian& jacobian, const JointVector& velocity_rad_s) {
  Eigen::Vector3d velocity = jacobian.leftCols<joint_count>() * velocity_rad_s.head<joint_count>();
  for (int i = joint_count; i < joint_slots; ++i) velocity += jacobian.col(i) * velocity_rad_s[i];
  return velocity;
}

Eigen::Matrix3d across(const Eigen::Vector3d& z) { return Eigen::Matrix3d::Identity() - z * z.transpose(); }

}  // namespace

HeadKinematics::HeadKinematics(const HeadChain& chain, const JointVector& q) : chain_(&chain) {
  SACCADE_CHECK(chain.common.size() <= common_axes_.size());
  const auto pass = [&q](const ChainLink& link, Eigen::Isometry3d& frame) {
    apply_before(link, frame);
    const Axis axis{frame.linear().col(2), frame.translation()};
    apply_turn(link, link.angle_rad(q), frame);
    return axis;
  };
  Eigen::Isometry3d frame = chain.root_from_base;
  chest_ = frame;
  neck_base_m_ = frame.translation();
  for (std::size_t i = 0; i < chain.common.size(); ++i) {
    common_axes_[i] = pass(chain.common[i], frame);
    if (i + 1 == chain.torso_links) chest_ = frame;
    if (i == chain.torso_links) neck_base_m_ = common_axes_[i].point_m;
  }
  for (const Eye eye : {Eye::left, Eye::right}) {
    const std::size_t e = index(eye);
    if (!chain.has(eye)) {
      root_from_eye_[e] = root_from_eye_[0];
      continue;
    }
    Eigen::Isometry3d& pose = root_from_eye_[e];
    pose = frame;
    SACCADE_CHECK(chain.eye[e].size() <= eye_axes_[e].size());
    for (std::size_t i = 0; i < chain.eye[e].size(); ++i) eye_axes_[e][i] = pass(chain.eye[e][i], pose);
    if (chain.has_eye_from_last) pose = pose * chain.eye_from_last[e];
  }
}

HeadKinematics::Axis HeadKinematics::axis_of(int slot, Eye eye) const {
  const auto is_turned = [slot](const ChainLink& link) {
    return (link.joints > 0 && link.turns[0].slot == slot) || (link.joints > 1 && link.turns[1].slot == slot);
  };
  for (std::size_t i = 0; i < chain_->common.size(); ++i) {
    if (is_turned(chain_->common[i])) return common_axes_[i];
  }
  const std::size_t e = chain_->has(eye) ? index(eye) : 0;
  for (std::size_t i = 0; i < chain_->eye[e].size(); ++i) {
    if (is_turned(chain_->eye[e][i])) return eye_axes_[e][i];
  }
  return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
}

EyeJacobian HeadKinematics::jacobian(Eye eye) const {
  const Eigen::Vector3d centre = root_from_eye(eye).translation();
  EyeJacobian j;
  j.linear.setZero();
  j.angular.setZero();
  const auto add = [&](const ChainLink& link, const Axis& axis) {
    if (!link.moves()) return;
    const Eigen::Vector3d moved = axis.direction.cross(centre - axis.point_m);
    for (int i = 0; i < link.joints; ++i) {
      const JointShare& by = link.turns[static_cast<std::size_t>(i)];
      j.angular.col(by.slot) += by.share * axis.direction;
      j.linear.col(by.slot) += by.share * moved;
    }
  };
  for (std::size_t i = 0; i < chain_->common.size(); ++i) add(chain_->common[i], common_axes_[i]);
  const std::size_t e = chain_->has(eye) ? index(eye) : 0;
  for (std::size_t i = 0; i < chain_->eye[e].size(); ++i) add(chain_->eye[e][i], eye_axes_[e][i]);
  return j;
}

FixationPoint HeadKinematics::fixation() const {
  // The point p nearest to both lines solves sum P_i (p - o_i) = 0, P_i the projector across axis i.
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& eye : root_from_eye_) {
    const Eigen::Matrix3d p = across(eye.linear().col(2));
    a += p;
    b += p * eye.translation();
  }
  const Eigen::Vector3d z_left = root_from_eye_[0].linear().col(2);
  const Eigen::Vector3d z_right = root_from_eye_[1].linear().col(2);
  if (!(z_left.cross(z_right).squaredNorm() > min_sine_squared)) return {};
  const Eigen::Vector3d point = a.inverse() * b;
  const bool in_front = z_left.dot(point - root_from_eye_[0].translation()) > 0.0 &&
                        z_right.dot(point - root_from_eye_[1].translation()) > 0.0;
  if (!in_front) return {};
  return {true, point};
}

PointJacobian HeadKinematics::fixation_jacobian() const {
  const FixationPoint at = fixation();
  if (!at.valid) return PointJacobian::Zero();
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  PointJacobian b = PointJacobian::Zero();
  for (const Eye eye : {Eye::left, Eye::right}) {
    const Eigen::Vector3d z = root_from_eye(eye).linear().col(2);
    const Eigen::Vector3d arm = at.point_m - root_from_eye(eye).translation();
    const Eigen::Matrix3d p = across(z);
    const EyeJacobian j = jacobian(eye);
    a += p;
    b += p * j.linear;
    for (int i = 0; i < joint_slots; ++i) {
      const Eigen::Vector3d dz = j.angular.col(i).cross(z);
      b.col(i) += dz * z.dot(arm) + z * dz.dot(arm);
    }
  }
  return a.inverse() * b;
}

CameraMotion camera_motion(const HeadChain& chain, const HeadState& state, Eye eye,
                           const Eigen::Isometry3d& eye_from_camera) {
  const HeadKinematics head(chain, state.position_rad);
  const Eigen::Isometry3d pose = head.root_from_eye(eye) * eye_from_camera;
  const EyeJacobian j = head.jacobian(eye);
  const Eigen::Vector3d angular = velocity_of(j.angular, state.velocity_rad_s);
  const Eigen::Vector3d arm_m = pose.translation() - head.root_from_eye(eye).translation();
  const Eigen::Vector3d linear = velocity_of(j.linear, state.velocity_rad_s) + angular.cross(arm_m);
  return {pose, pose.linear().transpose() * linear, pose.linear().transpose() * angular};
}

}  // namespace saccade
