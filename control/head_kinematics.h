#pragma once

#include <Eigen/Geometry>
#include <array>

#include "core/detector.h"
#include "head/head_state.h"

namespace saccade {

enum class Eye : int { left, right };

/// The point at which both optical axes intersect: the midpoint of their common perpendicular.
struct FixationPoint {
  /// False if the axes are parallel within 0.1 deg or intersect behind an eye; the point has no meaning then.
  bool valid = false;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< root
};

/// Column j: velocity of a point per velocity of joint j (order of Joint), m/rad. Root frame.
using PointJacobian = Eigen::Matrix<double, 3, joint_count>;
struct EyeJacobian {
  PointJacobian linear;   ///< m/s of the eye centre
  PointJacobian angular;  ///< rad/s of the eye
};

/// Forward kinematics of the iCub head, version 2, for one joint configuration. The chain is the DH chain of iKin: torso
/// pitch, roll, yaw, neck pitch, roll, yaw, eyes tilt, and one pan for each eye. The constructor computes everything;
/// nothing allocates.
///
/// Frames: root at the waist, x backward, y right, z up; the frame of an eye lies at the eye centre, with the axes of an
/// OpenCV camera: z along the optical axis, x right, y down. CameraMount gives the pose of the camera in this frame.
/// Source: iKinFwd.cpp (iKin, BSD-3), eye chain of versions 2.0 to 2.9.
class HeadKinematics {
 public:
  explicit HeadKinematics(const JointVector& position_rad);

  [[nodiscard]] const Eigen::Isometry3d& root_from_eye(Eye eye) const { return root_from_eye_[index(eye)]; }
  /// The unit axis of a joint and a point on it, root frame. `eyes_version` and `eyes_vergence` give the pan axes of the
  /// left and the right eye.
  [[nodiscard]] const Eigen::Vector3d& axis(Joint joint) const { return axes_[joint].direction; }
  [[nodiscard]] const Eigen::Vector3d& point_on_axis(Joint joint) const { return axes_[joint].point_m; }
  /// Unit vector out of the chest, root frame: (-1, 0, 0) with an upright torso.
  [[nodiscard]] Eigen::Vector3d chest_forward() const { return axis(neck_pitch).cross(axis(torso_yaw)); }

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

  std::array<Axis, joint_count> axes_;
  std::array<Eigen::Isometry3d, 2> root_from_eye_;
};

[[nodiscard]] Eigen::Isometry3d root_from_left_cam(const JointVector& position_rad);
[[nodiscard]] Eigen::Isometry3d root_from_right_cam(const JointVector& position_rad);

/// Pose and velocity of the camera in an eye, from the positions and velocities of the joints. The velocity is in the
/// camera's own frame.
[[nodiscard]] CameraMotion camera_motion(
    const HeadState& state, Eye eye = Eye::left,
    const Eigen::Isometry3d& eye_from_camera = Eigen::Isometry3d::Identity());

}  // namespace saccade
