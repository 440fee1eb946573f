#pragma once

#include <Eigen/Geometry>
#include <array>

#include "core/detector.h"
#include "head/head_state.h"

namespace saccade {

enum class Eye : int { left, right };

/// Where both optical axes meet: the midpoint of their common perpendicular.
struct FixationPoint {
  /// False when the axes are parallel within 0.1 deg or meet behind an eye; the point means nothing then.
  bool valid = false;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< root
};

/// Column j: what joint j (order of Joint) does at 1 rad/s. Root frame.
using PointJacobian = Eigen::Matrix<double, 3, joint_count>;
struct EyeJacobian {
  PointJacobian linear;   ///< m/s of the eye centre
  PointJacobian angular;  ///< rad/s of the eye
};

/// The iCub head, generation v2, as iKin's DH chain has it: torso pitch, roll, yaw, neck pitch, roll, yaw,
/// eyes tilt, and one pan for each eye. Computed once for one configuration, then asked; never allocates.
///
/// Frames: root at the waist, x backward, y right, z up; an eye is an OpenCV camera at the eye centre,
/// z the optical axis, x right, y down. The pinhole is taken to sit at the eye centre, as iKin did in 2016;
/// where it does not, CameraMount tells.
/// Source: iKinFwd.cpp (iKin, BSD-3), eye chain of versions 2.0 to 2.9.
class HeadKinematics {
 public:
  explicit HeadKinematics(const JointVector& position_rad);

  [[nodiscard]] const Eigen::Isometry3d& root_from_eye(Eye eye) const { return root_from_eye_[index(eye)]; }
  /// Unit axis that a joint turns about and a point on it, root frame; `eyes_version` and `eyes_vergence`
  /// stand for the pan of the left and of the right eye.
  [[nodiscard]] const Eigen::Vector3d& axis(Joint joint) const { return axes_[joint].direction; }
  [[nodiscard]] const Eigen::Vector3d& point_on_axis(Joint joint) const { return axes_[joint].point_m; }
  /// Unit vector out of the chest, root frame: (-1, 0, 0) with an upright torso.
  [[nodiscard]] Eigen::Vector3d chest_forward() const { return axis(neck_pitch).cross(axis(torso_yaw)); }

  [[nodiscard]] EyeJacobian jacobian(Eye eye) const;
  [[nodiscard]] FixationPoint fixation() const;
  /// Of the fixation point, m/rad; zero where it is not valid.
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

/// Pose of an eye's camera and its velocity in its own frame, from positions and velocities of the joints and
/// from where the camera sits in the eye.
[[nodiscard]] CameraMotion camera_motion(
    const HeadState& state, Eye eye = Eye::left,
    const Eigen::Isometry3d& eye_from_camera = Eigen::Isometry3d::Identity());

}  // namespace saccade
