#pragma once

#include <Eigen/Geometry>
#include <array>

#include "core/detector.h"
#include "head/head_chain.h"
#include "head/head_model.h"
#include "head/head_state.h"

namespace saccade {

/// The point at which both optical axes intersect: the midpoint of their common perpendicular.
struct FixationPoint {
  /// False if the axes are parallel within 0.1 deg or intersect behind an eye; the point has no meaning then.
  bool valid = false;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< root
};

/// Column j: velocity of a point per velocity of the joint with slot j, m/rad. Root frame.
using PointJacobian = Eigen::Matrix<double, 3, joint_slots>;
struct EyeJacobian {
  PointJacobian linear;   ///< m/s of the eye centre
  PointJacobian angular;  ///< rad/s of the eye
};

/// Forward kinematics of a head for one joint configuration. The constructor computes the poses; nothing allocates.
///
/// Frames: root at the waist, x backward, y right, z up; the frame of an eye lies at the eye centre, with the axes of an
/// OpenCV camera: z along the optical axis, x right, y down. CameraMount gives the pose of the camera in this frame.
class HeadKinematics {
 public:
  /// `chain` outlives this object.
  HeadKinematics(const HeadChain& chain, const JointVector& position_rad);

  [[nodiscard]] const Eigen::Isometry3d& root_from_eye(Eye eye) const { return root_from_eye_[index(eye)]; }
  /// The unit axis of the first link that a joint turns on the way to an eye, and a point on the axis; root frame. A joint
  /// that turns no such link has the axis 0.
  [[nodiscard]] Eigen::Vector3d axis(int slot, Eye eye = Eye::left) const {
    return axis_of(slot, eye).direction;
  }
  [[nodiscard]] Eigen::Vector3d point_on_axis(int slot, Eye eye = Eye::left) const {
    return axis_of(slot, eye).point_m;
  }
  /// The base of the neck: a point on the axis of the first joint that gaze commands, root frame.
  [[nodiscard]] const Eigen::Vector3d& neck_base_m() const { return neck_base_m_; }
  /// Unit vectors of the chest, root frame: to the right, up and forward, (0, 1, 0), (0, 0, 1) and (-1, 0, 0) with an
  /// upright torso.
  [[nodiscard]] Eigen::Vector3d chest_right() const { return chest_.linear() * chain_->chest_right; }
  [[nodiscard]] Eigen::Vector3d chest_up() const { return chest_.linear() * chain_->chest_up; }
  [[nodiscard]] Eigen::Vector3d chest_forward() const { return chest_up().cross(chest_right()); }

  [[nodiscard]] EyeJacobian jacobian(Eye eye) const;
  [[nodiscard]] FixationPoint fixation() const;
  /// The Jacobian of the fixation point, m/rad; zero if that is not valid.
  [[nodiscard]] PointJacobian fixation_jacobian() const;

 private:
  struct Axis {
    Eigen::Vector3d direction;
    Eigen::Vector3d point_m;
  };
  static std::size_t index(Eye eye) { return static_cast<std::size_t>(eye); }
  [[nodiscard]] Axis axis_of(int slot, Eye eye) const;

  const HeadChain* chain_;
  std::array<Axis, HeadChain::max_common_links> common_axes_;
  std::array<std::array<Axis, HeadChain::max_eye_links>, 2> eye_axes_;
  Eigen::Isometry3d chest_;
  Eigen::Vector3d neck_base_m_;
  std::array<Eigen::Isometry3d, 2> root_from_eye_;
};

/// Pose and velocity of the camera in an eye, from the positions and velocities of the joints. The velocity is in the
/// camera's own frame.
[[nodiscard]] CameraMotion camera_motion(
    const HeadChain& chain, const HeadState& state, Eye eye = Eye::left,
    const Eigen::Isometry3d& eye_from_camera = Eigen::Isometry3d::Identity());

}  // namespace saccade
