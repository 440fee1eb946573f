#pragma once

#include <Eigen/Geometry>

#include "control/head_kinematics.h"

namespace saccade {

/// Pitch, roll, yaw of the neck, rad.
using NeckVector = Eigen::Vector3d;

/// A virtual eye midway between both eyes. Its axes are those of the left eye with tilt, version and vergence at 0.
class CyclopeanEye {
 public:
  /// Uses torso and neck of `position_rad` only. `chain` outlives this object; it is that of a head with
  /// HeadModel::has_icub_gaze().
  CyclopeanEye(const HeadChain& chain, const JointVector& position_rad);

  /// Transforms a point from the root frame to the frame of this eye: x right, y down, z forward.
  [[nodiscard]] Eigen::Vector3d see(const Eigen::Vector3d& target_m) const {
    return root_from_eye_.inverse() * target_m;
  }
  /// The angle between the axis of this eye and a point, rad.
  [[nodiscard]] double angle_to(const Eigen::Vector3d& target_m) const;
  /// Half of the distance between left and right eye, m.
  [[nodiscard]] double half_baseline_m() const { return half_baseline_m_; }
  [[nodiscard]] const Eigen::Isometry3d& root_from_eye() const { return root_from_eye_; }
  [[nodiscard]] const HeadKinematics& head() const { return head_; }

 private:
  HeadKinematics head_;
  Eigen::Isometry3d root_from_eye_;
  double half_baseline_m_;
};

/// Computes the neck pose that points the cyclopean axis at a target. Of all such poses it is the one nearest to the rest
/// pose, in which the head is level and yaw is 0.
///
///     minimise 1/2 |x - x_rest|^2   subject to   axis on target,   limits,
///     (roll_min - roll_rest) f(pitch) <= roll - roll_rest <= (roll_max - roll_rest) f(pitch)
///
/// f = (1 + tanh(c (pitch - pitch_min - 5.5 deg))) / 2, c = 10 / deg, restricts roll: within 5.5 deg of the lowest pitch
/// roll stays at rest. For a target outside the workspace the pose has the least remaining angle.
///
/// Method: Gauss-Newton steps, each a bounded QP, over (pitch, roll / f, yaw), in which limits and guard are a box. The
/// distance to rest has the weight 1e-5 relative to the angle, which costs less than 0.001 deg. The result is a local
/// optimum; near the guard, and for a target above the range of the pitch, other optima can exist.
/// Source: the neck optimisation of iKinGazeCtrl, where IPOPT often stops before it converges.
class NeckSolver {
 public:
  /// Limits of pitch, roll, yaw, rad, min < max. `head` is one with HeadModel::has_icub_gaze().
  NeckSolver(std::shared_ptr<const HeadModel> head, const NeckVector& min_rad, const NeckVector& max_rad);

  struct Pose {
    NeckVector neck_rad = NeckVector::Zero();
    int iterations = 0;
    bool converged = false;
  };
  static constexpr int max_iterations = 50;
  static constexpr int max_halvings = 20;  ///< from the longest step to one that is too short to matter

  /// `position_rad`: its torso joints are used. `start_rad`: initial pose. At most max_iterations steps, each halved at most
  /// max_halvings times. With values that are not finite, or that overflow, the pose is the rest pose and not converged.
  /// Does not allocate.
  [[nodiscard]] Pose solve(const JointVector& position_rad, const Eigen::Vector3d& target_m,
                           const NeckVector& start_rad) const;
  /// The allowed share of the roll range at a pitch, 0 to 1: f above.
  [[nodiscard]] double guard(double pitch_rad) const;
  /// The rest pose: the head level with respect to gravity as far as the limits allow, and yaw 0.
  [[nodiscard]] NeckVector rest(const JointVector& position_rad) const;

 private:
  std::shared_ptr<const HeadModel> model_;
  NeckVector min_rad_, max_rad_;
};

}  // namespace saccade
