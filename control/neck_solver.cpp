#include "control/neck_solver.h"

#include <algorithm>
#include <cmath>

#include "control/bearing.h"
#include "control/bounded_qp.h"
#include "control/joint_limiter.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double guard_rad = 5.5 * rad_per_deg;       // above the lowest pitch
constexpr double guard_per_rad = 10.0 / rad_per_deg;  // steepness
constexpr double rest_weight = 1e-5;                  // of the distance to rest, against the angle left
constexpr double ridge = 1e-9;                        // where the guard leaves roll no effect
constexpr double longest_step_rad = 0.3;
constexpr double converged_rad = 1e-6;

/// The bearing of the target relative to the cyclopean axis, rad, and its Jacobian by the neck joints.
struct NeckError {
  Eigen::Vector2d error;
  Eigen::Matrix<double, 2, 3> jacobian;
};

NeckError neck_error(const CyclopeanEye& eye, const Eigen::Vector3d& target_m) {
  const Eigen::Matrix3d eye_from_root = eye.root_from_eye().linear().transpose();
  const Eigen::Vector3d centre_m = eye.root_from_eye().translation();
  const Eigen::Vector3d p = eye.see(target_m);
  Eigen::Matrix3d dp;
  for (int j = 0; j < 3; ++j) {
    const auto joint = static_cast<Joint>(neck_pitch + j);
    const Eigen::Vector3d axis = eye.head().axis(joint);
    const Eigen::Vector3d centre_velocity = axis.cross(centre_m - eye.head().point_on_axis(joint));
    dp.col(j) = -(eye_from_root * centre_velocity) - (eye_from_root * axis).cross(p);
  }
  const Bearing bearing = bearing_of(p);
  NeckError e;
  e.error << bearing.azimuth_rad, bearing.elevation_rad;
  e.jacobian << bearing.azimuth_by_point * dp, bearing.elevation_by_point * dp;
  return e;
}

}  // namespace

CyclopeanEye::CyclopeanEye(const HeadChain& chain, const JointVector& position_rad)
    : head_([&] {
        JointVector straight = position_rad;
        straight.segment<3>(eyes_tilt).setZero();
        return HeadKinematics(chain, straight);
      }()),
      root_from_eye_(head_.root_from_eye(Eye::left)) {
  const Eigen::Vector3d left_m = head_.root_from_eye(Eye::left).translation();
  const Eigen::Vector3d right_m = head_.root_from_eye(Eye::right).translation();
  root_from_eye_.translation() = (left_m + right_m) / 2;
  half_baseline_m_ = (right_m - left_m).norm() / 2;
}

double CyclopeanEye::angle_to(const Eigen::Vector3d& target_m) const {
  const Eigen::Vector3d p = see(target_m);
  return std::atan2(p.head<2>().norm(), p.z());
}

NeckSolver::NeckSolver(std::shared_ptr<const HeadModel> head, const NeckVector& min_rad,
                       const NeckVector& max_rad)
    : model_(std::move(head)), min_rad_(min_rad), max_rad_(max_rad) {
  SACCADE_CHECK((min_rad_.array() < max_rad_.array()).all());
}

double NeckSolver::guard(double pitch_rad) const {
  return 0.5 * (1.0 + std::tanh(guard_per_rad * (pitch_rad - min_rad_[0] - guard_rad)));
}

NeckVector NeckSolver::rest(const JointVector& position_rad) const {
  // Where up is, seen from the chest: backward, right and up of it.
  const HeadKinematics head(model_->chain, position_rad);
  const double backward = -head.chest_forward().z();
  const double right = head.chest_right().z();
  const double up = head.chest_up().z();
  const NeckVector level(std::atan2(backward, up), std::asin(std::clamp(right, -1.0, 1.0)), 0.0);
  return level.cwiseMax(min_rad_).cwiseMin(max_rad_);
}

NeckSolver::Pose NeckSolver::solve(const JointVector& position_rad, const Eigen::Vector3d& target_m,
                                   const NeckVector& start_rad) const {
  if (!is_reading(position_rad)) return {rest(JointVector::Zero()), 0, false};
  const NeckVector rest_rad = rest(position_rad);
  const Pose unsolved{rest_rad, 0, false};
  JointVector q = position_rad;
  const auto neck_of = [&](const NeckVector& u) -> NeckVector {
    return {u[0], rest_rad[1] + guard(u[0]) * u[1], u[2]};
  };
  const auto see = [&](const NeckVector& neck_rad) {
    q.segment<3>(neck_pitch) = neck_rad;
    return neck_error(CyclopeanEye(model_->chain, q), target_m);
  };
  const auto cost_of = [&](const NeckError& b, const NeckVector& neck_rad) {
    return b.error.squaredNorm() + rest_weight * (neck_rad - rest_rad).squaredNorm();
  };
  NeckVector lower = min_rad_, upper = max_rad_;
  lower[1] -= rest_rad[1];
  upper[1] -= rest_rad[1];

  if (!start_rad.allFinite() || !target_m.allFinite()) return unsolved;
  NeckVector u = start_rad.cwiseMax(min_rad_).cwiseMin(max_rad_);
  u[1] -= rest_rad[1];
  NeckVector neck_rad = neck_of(u);
  NeckError here = see(neck_rad);
  double cost = cost_of(here, neck_rad);
  Pose pose;
  // The distance to the target, or its square, overflows.
  if (!std::isfinite(cost) || !here.jacobian.allFinite()) return unsolved;
  while (!pose.converged && pose.iterations < max_iterations) {
    ++pose.iterations;
    const double f = guard(u[0]);
    Eigen::Matrix3d neck_by_u = Eigen::Matrix3d::Identity();
    neck_by_u(1, 0) = u[1] * 2.0 * guard_per_rad * f * (1.0 - f);
    neck_by_u(1, 1) = f;
    const Eigen::Matrix<double, 2, 3> j = here.jacobian * neck_by_u;
    const Eigen::Matrix3d h = j.transpose() * j + rest_weight * neck_by_u.transpose() * neck_by_u +
                              ridge * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d g =
        -(j.transpose() * here.error) - rest_weight * (neck_by_u.transpose() * (neck_rad - rest_rad));
    const NeckVector longest = NeckVector::Constant(longest_step_rad);
    NeckVector step =
        BoundedQp<3>().solve(h, g, (lower - u).cwiseMax(-longest), (upper - u).cwiseMin(longest)).x;
    // Halved until it helps; one that has become too short to matter ends the search.
    for (int halvings = 0;; ++halvings, step /= 2) {
      pose.converged = halvings == max_halvings || step.cwiseAbs().maxCoeff() < converged_rad;
      const NeckVector next = (u + step).cwiseMax(lower).cwiseMin(upper);
      const NeckVector next_rad = neck_of(next);
      const NeckError there = see(next_rad);
      const double next_cost = cost_of(there, next_rad);
      if (next_cost <= cost) {
        u = next;
        neck_rad = next_rad;
        here = there;
        cost = next_cost;
        break;
      }
      if (pose.converged) break;
    }
  }
  pose.neck_rad = neck_rad;
  return pose;
}

}  // namespace saccade
