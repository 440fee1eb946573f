#include "control/qp_controller.h"

#include <algorithm>
#include <cmath>

#include "control/bearing.h"
#include "core/units.h"

namespace saccade {
namespace {

using Row = Eigen::Matrix<double, 1, gaze_slots>;

constexpr double before_catch_up_s = 0.02;
constexpr double catch_up_interval_s = 0.15;
constexpr double longest_catch_up_s = 0.1;

/// The bearing of a target in an eye, rad, its rate and its Jacobian by the head joints.
struct EyeError {
  double azimuth;
  double elevation;
  double azimuth_rate;  ///< from the velocity of the target, rad/s
  double elevation_rate;
  Row azimuth_row;
  Row elevation_row;
};

EyeError eye_error(const HeadKinematics& head, Eye eye, int joints, const TargetMotion& target,
                   const BodyRates& body) {
  const Eigen::Isometry3d& pose = head.root_from_eye(eye);
  const EyeJacobian jacobian = head.jacobian(eye);
  const Eigen::Matrix3d eye_from_root = pose.linear().transpose();
  const Eigen::Vector3d p = eye_from_root * (target.position_m - pose.translation());
  Eigen::Vector3d velocity = eye_from_root * target.velocity_m_s;
  if (!body.is_zero()) {
    const auto torso = [&](const PointJacobian& by_joints) -> Eigen::Vector3d {
      return by_joints.leftCols<torso_slots>() * body.torso_rad_s;
    };
    const Eigen::Vector3d turns = eye_from_root * (torso(jacobian.angular) + body.base_rad_s);
    velocity -=
        eye_from_root * (torso(jacobian.linear) + body.base_rad_s.cross(pose.translation())) + turns.cross(p);
  }
  Eigen::Matrix<double, 3, gaze_slots> dp = Eigen::Matrix<double, 3, gaze_slots>::Zero();
  for (int j = 0; j < joints; ++j) {
    const int joint = torso_slots + j;
    dp.col(j) = -(eye_from_root * jacobian.linear.col(joint)) -
                (eye_from_root * jacobian.angular.col(joint)).cross(p);
  }
  const Bearing bearing = bearing_of(p);
  return {bearing.azimuth_rad,
          bearing.elevation_rad,
          bearing.azimuth_by_point.dot(velocity),
          bearing.elevation_by_point.dot(velocity),
          bearing.azimuth_by_point * dp,
          bearing.elevation_by_point * dp};
}

}  // namespace

void describe(FieldVisitor& v, QpConfig& config) {
  v.choice("eyes", config.eyes, "eyes whose optical axes point at the target");
  v.real("eye_time_constant_s", config.eye_time_constant_s, {0.005, 5.0}, "time constant of the gaze error");
  v.real("neck_time_constant_s", config.neck_time_constant_s, {0.02, 20.0},
         "time constant with which the neck takes over the rotation of the eyes");
  v.real("right_eye_weight", config.right_eye_weight, {1e-4, 1.0},
         "weight of the right eye's error; that of the left eye is 1");
  v.real("neck_weight", config.neck_weight, {1e-6, 1.0}, "weight of the neck's motion");
  v.real("damping", config.damping, {1e-9, 1e-2}, "weight of every joint's velocity");
  v.real("target_time_constant_s", config.target_time_constant_s, {0.0, 2.0},
         "time constant of the estimate of the target's velocity; 0: none, the gaze lags behind");
  v.real("max_lead_deg", config.max_lead_deg, {0.1, 60.0},
         "largest distance of a reference from the measured joint");
  v.boolean("predict_motion", config.predict_motion,
            "whether periodic motion and free fall of the target are predicted");
  v.real("catch_up_deg", config.catch_up_deg, {0.0, 90.0},
         "gaze error that starts a catch-up saccade; 0: none");
  v.real("catch_up_time_constant_s", config.catch_up_time_constant_s, {0.005, 1.0},
         "time constant of the gaze error during a catch-up saccade");
}

QpController::QpController(const QpConfig& config, const MotionLimits& limits)
    : config_(config),
      both_eyes_(config.eyes == AimingEyes::both),
      max_lead_rad_(config.max_lead_deg * rad_per_deg),
      limits_(limits),
      target_(config.target_time_constant_s, config.predict_motion) {
  check_config("gaze.qp", config);
  const HeadModel& model = *limits_.head;
  both_eyes_ = both_eyes_ && model.chain.eyes > 1;
  const HeadKinematics head(model.chain, JointVector::Zero());
  const EyeJacobian left = head.jacobian(Eye::left);
  const EyeJacobian right = head.jacobian(Eye::right);
  int right_only = 0;
  for (int j = model.neck_joints(); j < limits_.joints; ++j) {
    const Eigen::Vector3d by_left = left.angular.col(torso_slots + j);
    const Eigen::Vector3d by_right = right.angular.col(torso_slots + j);
    const bool turns_left = !by_left.isZero(1e-9);
    if (!turns_left) ++right_only;
    eye_joints_.push_back(
        {j, turns_left ? Eye::left : Eye::right, turns_left, !(by_left + by_right).isZero(1e-9)});
  }
  aims_right_elevation_ = right_only > 1;
  const Eigen::Vector3d ahead = head.root_from_eye(Eye::left).linear().col(2);
  for (int j = 0; j < model.neck_joints(); ++j) {
    if (std::abs(head.axis(torso_slots + j).dot(ahead)) > 0.7) levelled_.push_back(j);
  }
}

void QpController::Cost::add(double weight, const Row& row, double wanted) {
  const double weighted = weight * wanted;
  for (int j = 0; j < joints; ++j) {
    for (int i = 0; i < joints; ++i) h(i, j) += weight * row[i] * row[j];
    g[j] += weighted * row[j];
  }
}

HeadJointVector QpController::step(const HeadState& state, const std::optional<Eigen::Vector3d>& target,
                                   double dt_s) {
  SACCADE_CHECK(dt_s > 0.0);
  const double dt = bounded_step_s(dt_s);
  const bool measured = is_reading(state.position_rad);
  if (!started_) {
    reference_rad_ = inside_hardware(limits_, state.head_position_rad());
    started_ = measured;
  }
  status_ = TargetStatus::none;
  target_.advance(dt);
  if (!measured) {
    velocity_rad_s_.setZero();
    history_.push(reference_rad_);
    return reference_rad_;
  }
  const HeadJointVector q = joints_ahead(state.head_position_rad(), dt);
  JointVector joints = state.position_rad;
  joints.tail<gaze_slots>() = q;
  const HeadKinematics head(limits_.head->chain, joints);
  if (target) {
    status_ = check_gaze_target(*target, head);
    if (status_ == TargetStatus::ok) target_.observe(body_.level_from_root * *target, delays_.sight_s);
  }
  catch_up_since_s_ += dt;
  behind_s_ += dt;
  integrate(target_.is_known() ? gaze_cost(head, q) : neutral_cost(q), q, dt);
  history_.push(reference_rad_);
  return reference_rad_;
}

/// The joints when the next reference will move the eyes.
HeadJointVector QpController::joints_ahead(const HeadJointVector& q, double dt) const {
  if (delays_.neck_s == 0.0 && delays_.eyes_s == 0.0) return q;
  HeadJointVector ahead = q;
  const auto moved = [&](double delay_s) {
    const double then_s =
        delay_s - delays_.eyes_s;  // after `delay_s`, of the reference that moves the joint then
    return HeadJointVector(history_.at(std::max(0.0, then_s) / dt) - history_.at(delay_s / dt));
  };
  const int neck = limits_.head->neck_joints();
  ahead.head(neck) += moved(delays_.neck_s).head(neck);
  ahead.tail(gaze_slots - neck) += moved(delays_.eyes_s).tail(gaze_slots - neck);
  return ahead;
}

void QpController::update_catch_up(double error_rad) {
  if (config_.catch_up_deg == 0.0 || slowdown_ > 1.0) return;
  const double limit_rad = config_.catch_up_deg * rad_per_deg;
  if (error_rad < limit_rad) behind_s_ = 0.0;
  if (catching_up_) {
    catching_up_ = error_rad > 0.25 * limit_rad && catch_up_since_s_ < longest_catch_up_s;
  } else if (behind_s_ > before_catch_up_s && catch_up_since_s_ > catch_up_interval_s) {
    catching_up_ = true;
    catch_up_since_s_ = 0.0;
  }
}

void QpController::set_slowdown(double factor) {
  if (factor == slowdown_) return;
  slowdown_ = factor;
  catching_up_ = false;
  target_.set_time_constant(factor * config_.target_time_constant_s);
}

QpController::Cost QpController::gaze_cost(const HeadKinematics& head, const HeadJointVector& q) {
  const double per_neck_time = 1.0 / (slowdown_ * config_.neck_time_constant_s);
  const int neck_joints = limits_.head->neck_joints();
  const auto to_rest = [&](int j) {
    return (std::clamp(0.0, limits_.min_rad[j], limits_.max_rad[j]) - q[j]) * per_neck_time;
  };

  Cost cost(limits_.joints, config_.damping);
  TargetMotion target = target_.predict(delays_.eyes_s);
  const Eigen::Quaterniond root_from_level = body_.level_from_root.conjugate();
  target = {root_from_level * target.position_m, root_from_level * target.velocity_m_s};
  const EyeError left = eye_error(head, Eye::left, limits_.joints, target, body_);
  update_catch_up(std::hypot(left.azimuth, left.elevation));
  const double per_eye_time =
      1.0 / (catching_up_ ? config_.catch_up_time_constant_s : slowdown_ * config_.eye_time_constant_s);
  cost.add(1.0, left.azimuth_row, -left.azimuth * per_eye_time - left.azimuth_rate);
  cost.add(1.0, left.elevation_row, -left.elevation * per_eye_time - left.elevation_rate);
  if (both_eyes_) {
    const EyeError right = eye_error(head, Eye::right, limits_.joints, target, body_);
    cost.add(config_.right_eye_weight, right.azimuth_row, -right.azimuth * per_eye_time - right.azimuth_rate);
    if (aims_right_elevation_) {
      cost.add(config_.right_eye_weight, right.elevation_row,
               -right.elevation * per_eye_time - right.elevation_rate);
    }
  } else {
    for (const EyeJoint& joint : eye_joints_) {
      if (joint.conjugate && joint.turns_left) continue;
      cost.add(config_.neck_weight, Row::Unit(joint.index), to_rest(joint.index));
    }
  }

  // The head's angular velocity about the eyes' own axes, from the neck joints alone.
  for (const EyeJoint& joint : eye_joints_) {
    if (!joint.conjugate || neck_joints == 0) continue;
    const Eigen::Vector3d axis = head.axis(torso_slots + joint.index, joint.eye);
    Row row = Row::Zero();
    for (int j = 0; j < neck_joints; ++j) row[j] = head.axis(torso_slots + j).dot(axis);
    cost.add(config_.neck_weight, row, q[joint.index] * per_neck_time);
  }
  for (const int j : levelled_) cost.add(config_.neck_weight, Row::Unit(j), to_rest(j));
  return cost;
}

QpController::Cost QpController::neutral_cost(const HeadJointVector& q) const {
  Cost cost(limits_.joints, 1.0);
  for (int j = 0; j < limits_.joints; ++j) {
    cost.g[j] =
        (std::clamp(0.0, limits_.min_rad[j], limits_.max_rad[j]) - q[j]) / config_.neck_time_constant_s;
  }
  return cost;
}

HeadJointVector QpController::solve(const Cost& cost, const HeadJointVector& slowest,
                                    const HeadJointVector& fastest) {
  constexpr int small = head_joint_count;
  if (limits_.joints > small) return large_qp_.solve(cost.h, cost.g, slowest, fastest).x;
  HeadJointVector velocity = HeadJointVector::Zero();
  velocity.head<small>() = small_qp_
                               .solve(cost.h.topLeftCorner<small, small>(), cost.g.head<small>(),
                                      slowest.head<small>(), fastest.head<small>())
                               .x;
  return velocity;
}

void QpController::integrate(const Cost& cost, const HeadJointVector& q, double dt) {
  HeadJointVector slowest = HeadJointVector::Zero();
  HeadJointVector fastest = HeadJointVector::Zero();
  for (int j = 0; j < limits_.joints; ++j) {
    const VelocityRange range = allowed_velocity(limits_, j, reference_rad_[j], velocity_rad_s_[j], dt);
    const double lead = reference_rad_[j] - q[j];
    slowest[j] = lead < -max_lead_rad_ ? std::max(range.min, 0.0) : range.min;
    fastest[j] = lead > max_lead_rad_ ? std::min(range.max, 0.0) : range.max;
    if (slowest[j] > fastest[j]) slowest[j] = fastest[j] = std::clamp(0.0, range.min, range.max);
  }
  const HeadJointVector velocity = solve(cost, slowest, fastest);
  for (int j = 0; j < limits_.joints; ++j) {
    const double before = reference_rad_[j];
    reference_rad_[j] = std::clamp(before + velocity[j] * dt, std::min(before, limits_.min_rad[j]),
                                   std::max(before, limits_.max_rad[j]));
    velocity_rad_s_[j] = (reference_rad_[j] - before) / dt;
  }
}

}  // namespace saccade
