#pragma once

#include <Eigen/Geometry>

#include "control/head_kinematics.h"

namespace saccade {

/// Pitch, roll, yaw of the neck, rad.
using NeckVector = Eigen::Vector3d;

/// The eye that sits between the eyes and looks where the head does: left camera's axes with tilt, version and
/// vergence at 0.
class CyclopeanEye {
 public:
  /// Only torso and neck of `position_rad` matter.
  explicit CyclopeanEye(const JointVector& position_rad);

  /// Of a point (root frame), in this eye's frame: x right, y down, z forward.
  [[nodiscard]] Eigen::Vector3d see(const Eigen::Vector3d& target_m) const {
    return root_from_eye_.inverse() * target_m;
  }
  /// Between this eye's axis and a point, rad.
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

/// The neck pose that turns the head to a target: the cyclopean axis exactly on it and, of the poses that do
/// that, the one nearest to rest, which levels the head to gravity and has yaw 0.
///
///     minimise 1/2 |x - x_rest|^2   subject to   axis on target,   limits,
///     (roll_min - roll_rest) f(pitch) <= roll - roll_rest <= (roll_max - roll_rest) f(pitch)
///
/// f = (1 + tanh(c (pitch - pitch_min - 5.5 deg))) / 2, c = 10 / deg, is the roll guard: with the head down,
/// within 5.5 deg of the lowest pitch, roll stays at rest. A target that the limits keep off the axis gets the
/// pose with the least angle left.
///
/// Gauss-Newton steps, each a bounded QP, over (pitch, roll / f, yaw), in which limits and guard are a box; the
/// distance to rest counts 1e-5 of the angle left, which that costs less than 0.001 deg. A local optimum from
/// where it starts: near the guard, and for a target above what the pitch can reach, there may be another one.
/// Problem: iKinGazeCtrl's neck optimisation; there IPOPT often stops early, here it converges.
class NeckSolver {
 public:
  /// Limits of pitch, roll, yaw, rad, min < max.
  NeckSolver(const NeckVector& min_rad, const NeckVector& max_rad);

  struct Pose {
    NeckVector neck_rad = NeckVector::Zero();
    int iterations = 0;
    bool converged = false;
  };
  static constexpr int max_iterations = 50;

  /// `position_rad` gives the torso; the search starts at `start_rad`. The target is finite. Never allocates.
  [[nodiscard]] Pose solve(const JointVector& position_rad, const Eigen::Vector3d& target_m,
                           const NeckVector& start_rad) const;
  /// What the guard leaves of the way between rest and a limit of roll, 0 to 1.
  [[nodiscard]] double guard(double pitch_rad) const;
  /// Levels the head to gravity, as far as limits allow.
  [[nodiscard]] NeckVector rest(const JointVector& position_rad) const;

 private:
  NeckVector min_rad_, max_rad_;
};

}  // namespace saccade
