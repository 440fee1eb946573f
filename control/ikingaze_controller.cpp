#include "control/ikingaze_controller.h"

#include <algorithm>
#include <cmath>

#include "core/small_solve.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double period_s = 0.01;
constexpr double due_s = 1e-9;  // rounding
constexpr double eye_gain_per_s = 12.5;
constexpr double least_vergence_rad = 0.5 * rad_per_deg;
constexpr double neck_activation_rad = 2.5 * rad_per_deg;
constexpr double neck_restoring_rad = 5.0 * rad_per_deg;
constexpr double neck_delay_s = 0.25;
constexpr double saccade_done_rad = 0.1 * rad_per_deg;
constexpr double longest_saccade_s = 0.5;            // an eye that does not arrive is not waited for
constexpr double max_lead_rad = 10.0 * rad_per_deg;  // a reference waits for its joint
constexpr double fastest_rad_s = 1e6;                // that a joint can be asked for

MotionLimits with_tilt(MotionLimits limits, const IkinGazeConfig& config) {
  if (!limits.head->has_icub_gaze()) {
    throw InputError(
        "gaze.controller", "ikingaze",
        "qp or script: ikingaze needs a head with three neck joints, tilt, version and vergence, and " +
            limits.head->name + " has others");
  }
  limits.min_rad[head_index(eyes_tilt)] =
      std::max(limits.min_rad[head_index(eyes_tilt)], config.min_tilt_deg * rad_per_deg);
  limits.max_rad[head_index(eyes_tilt)] =
      std::min(limits.max_rad[head_index(eyes_tilt)], config.max_tilt_deg * rad_per_deg);
  if (!(limits.min_rad[head_index(eyes_tilt)] < limits.max_rad[head_index(eyes_tilt)])) {
    throw InputError("gaze.ikingaze.min_tilt_deg", text_of(config.min_tilt_deg),
                     "a tilt below what the head's limits leave");
  }
  return limits;
}

/// Where an eye looks whose tilt and pan are given, in the frame of the cyclopean eye.
Eigen::Vector3d direction(double tilt_rad, double pan_rad) {
  return {std::sin(pan_rad), -std::sin(tilt_rad) * std::cos(pan_rad), std::cos(tilt_rad) * std::cos(pan_rad)};
}

/// A velocity that the joints' limits can bound: 0 for one that is no number.
double bounded_rate(double rad_s) {
  return std::isnan(rad_s) ? 0.0 : std::clamp(rad_s, -fastest_rad_s, fastest_rad_s);
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

void describe(FieldVisitor& v, IkinGazeConfig& config) {
  v.choice("eyes", config.eyes, "eyes whose optical axes point at the target");
  v.real("neck_time_s", config.neck_time_s, {0.3, 20.0}, "duration of a movement of the neck");
  v.real("eyes_time_s", config.eyes_time_s, {0.1, 20.0}, "duration of a movement of the eyes");
  v.require(config.neck_time_s >= config.eyes_time_s + 0.2, "neck_time_s", text_of(config.neck_time_s),
            "at least 0.2 s more than eyes_time_s");
  v.boolean("saccades", config.saccades, "whether the eyes make saccades to distant targets");
  v.real("saccade_angle_deg", config.saccade_angle_deg, {1.0, 90.0}, "least angle of a saccade");
  v.real("saccade_interval_s", config.saccade_interval_s, {0.05, 60.0},
         "least time between the starts of two saccades");
  v.real("min_tilt_deg", config.min_tilt_deg, {-90.0, 0.0}, "lowest tilt of the eyes");
  v.real("max_tilt_deg", config.max_tilt_deg, {0.0, 90.0}, "highest tilt of the eyes");
}

IkinGazeController::IkinGazeController(const IkinGazeConfig& config, const MotionLimits& limits)
    : config_(check_config("gaze.ikingaze", config)),
      both_eyes_(config.eyes == AimingEyes::both),
      limits_(with_tilt(limits, config)),
      neutral_rad_(HeadJointVector::Zero().cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad)),
      neck_solver_(limits_.head, limits_.min_rad.head<neck_joint_count>(),
                   limits_.max_rad.head<neck_joint_count>()),
      filters_{
          MinimumJerkFilter(config.neck_time_s, period_s), MinimumJerkFilter(config.neck_time_s, period_s),
          MinimumJerkFilter(config.neck_time_s, period_s), MinimumJerkFilter(config.eyes_time_s, period_s),
          MinimumJerkFilter(config.eyes_time_s, period_s), MinimumJerkFilter(config.eyes_time_s, period_s)},
      saccade_start_s_(-config.saccade_interval_s) {}

HeadJointVector IkinGazeController::step(const HeadState& state, const std::optional<Eigen::Vector3d>& target,
                                         double dt) {
  SACCADE_CHECK(dt > 0.0);
  const bool measured = is_reading(state.position_rad);
  if (!started_) {
    reference_rad_ = inside_hardware(limits_, state.head_position_rad());
    goal_rad_.head<neck_joint_count>() = neutral_rad_.head<neck_joint_count>();
    goal_rad_.segment<3>(neck_joint_count) = inside_limits(reference_rad_.segment<3>(neck_joint_count));
    started_ = measured;
  }
  status_ = TargetStatus::none;
  if (!measured) {
    for (MinimumJerkFilter& filter : filters_) filter.reset();
    velocity_rad_s_.setZero();
    wanted_rad_s_.setZero();
    return reference_rad_;
  }
  if (target) {
    status_ = check_gaze_target(*target, HeadKinematics(limits_.head->chain, state.position_rad));
    if (status_ == TargetStatus::ok) {
      target_m_ = target;
      target_is_new_ = true;
      if (!neck_waits_since_s_) neck_waits_since_s_ = now_s_;
    }
  }
  const HeadJointVector before_rad = reference_rad_;
  for (double left_s = bounded_step_s(dt); left_s > due_s;) {
    // Joints move with their references where a step is longer than a period.
    JointVector q = state.position_rad;
    q.tail<gaze_slots>() += reference_rad_ - before_rad;
    if (until_control_s_ <= due_s) {
      control(q);
      until_control_s_ += period_s;
    }
    const double part_s = left_s - until_control_s_ < due_s ? left_s : until_control_s_;
    integrate(q.tail<gaze_slots>(), part_s);
    left_s -= part_s;
    until_control_s_ -= part_s;
    now_s_ += part_s;
  }
  return reference_rad_;
}

void IkinGazeController::rest() {
  target_m_.reset();
  neck_target_m_.reset();
  neck_waits_since_s_.reset();
  target_is_new_ = false;
}

void IkinGazeController::control(const JointVector& q) {
  if (plan_now_) {
    plan_neck(q);
    plan_eyes(q);
  }
  plan_now_ = !plan_now_;
  for (int j = 0; j < head_joint_count; ++j) {
    if (saccade_ && j >= neck_joint_count) continue;
    MinimumJerkFilter& filter = filters_[static_cast<std::size_t>(j)];
    wanted_rad_s_[j] =
        filter.step(goal_rad_[j], goal_velocity_rad_s_[j], q[torso_joint_count + j]) + counter_rad_s_[j];
  }
}

void IkinGazeController::plan_neck(const JointVector& q) {
  if (!target_m_) {
    goal_rad_.head<neck_joint_count>() = neutral_rad_.head<neck_joint_count>();
    return;
  }
  const CyclopeanEye eye(limits_.head->chain, q);
  if (neck_waits_since_s_ && (eye.angle_to(*target_m_) > neck_restoring_rad ||
                              now_s_ - *neck_waits_since_s_ >= neck_delay_s - due_s)) {
    neck_target_m_ = target_m_;
    neck_waits_since_s_.reset();
  }
  if (neck_target_m_ && eye.angle_to(*neck_target_m_) > neck_activation_rad) {
    const NeckVector start_rad = goal_rad_.head<neck_joint_count>();
    goal_rad_.head<neck_joint_count>() = neck_solver_.solve(q, *neck_target_m_, start_rad).neck_rad;
    neck_target_m_.reset();
  }
}

void IkinGazeController::plan_eyes(const JointVector& q) {
  if (saccade_) end_saccade(q);
  if (!saccade_ && target_is_new_) plan_saccade(q);
  target_is_new_ = false;
  EyeMotion motion{Eyes::Zero(), Eyes::Zero()};
  if (!saccade_) {
    if (target_m_) {
      motion = both_eyes_ ? both_eyes(q) : left_eye(q);
    } else {
      motion.wanted_rad_s = eye_gain_per_s * (neutral_rad_ - goal_rad_).segment<3>(neck_joint_count);
    }
  }
  // An eye at its limit stays there.
  for (int i = 0; i < 3; ++i) {
    const int j = neck_joint_count + i;
    const double wanted = bounded_rate(motion.wanted_rad_s[i]);
    const double counter = bounded_rate(motion.counter_rad_s[i]);
    const double limit = wanted + counter > 0.0 ? limits_.max_rad[j] : limits_.min_rad[j];
    const bool stays = goal_rad_[j] == limit;
    goal_velocity_rad_s_[j] = stays ? 0.0 : wanted;
    counter_rad_s_[j] = stays ? 0.0 : counter;
  }
}

void IkinGazeController::plan_saccade(const JointVector& q) {
  if (!config_.saccades || now_s_ - saccade_start_s_ < config_.saccade_interval_s) return;
  const auto look = [&](const Eyes& eyes_rad) {
    return direction(eyes_rad[0], both_eyes_ ? eyes_rad[1] : eyes_rad[1] + eyes_rad[2] / 2);
  };
  const Eyes there_rad = eyes_on_target(q);
  if (angle_between(look(there_rad), look(q.segment<3>(eyes_tilt))) <=
      config_.saccade_angle_deg * rad_per_deg)
    return;
  saccade_ = true;
  saccade_start_s_ = now_s_;
  goal_rad_.segment<3>(neck_joint_count) = there_rad;
}

void IkinGazeController::end_saccade(const JointVector& q) {
  const bool arrived = (goal_rad_ - q.tail<gaze_slots>()).segment<3>(neck_joint_count).cwiseAbs().maxCoeff() <
                       saccade_done_rad;
  if (!arrived && now_s_ - saccade_start_s_ < longest_saccade_s) return;
  saccade_ = false;
  goal_rad_.segment<3>(neck_joint_count) = inside_limits(q.segment<3>(eyes_tilt));
  for (std::size_t j = neck_joint_count; j < filters_.size(); ++j) filters_[j].reset();
}

IkinGazeController::EyeMotion IkinGazeController::both_eyes(const JointVector& q) const {
  JointVector planned = q;
  planned.segment<3>(eyes_tilt) = goal_rad_.segment<3>(neck_joint_count);
  planned[eyes_vergence] = std::max(planned[eyes_vergence], least_vergence_rad);
  const HeadKinematics there(limits_.head->chain, planned);
  const FixationPoint fixation = there.fixation();
  if (!fixation.valid) return {Eyes::Zero(), Eyes::Zero()};
  JointVector now = q;
  now[eyes_vergence] = std::max(now[eyes_vergence], least_vergence_rad);
  const PointJacobian here = HeadKinematics(limits_.head->chain, now).fixation_jacobian();
  const auto by_eyes = [](const PointJacobian& jacobian, const Eigen::Vector3d& velocity_m_s) -> Eyes {
    return least_norm_solution(Eigen::Matrix3d(jacobian.middleCols<3>(eyes_tilt)), velocity_m_s);
  };
  Eigen::Vector3d carried_m_s =
      here.middleCols<neck_joint_count>(neck_pitch) * (ocr_ * velocity_rad_s_.head<neck_joint_count>());
  if (vor_ != 0.0) {
    const Eigen::Vector3d between =
        0.5 * (there.root_from_eye(Eye::left).translation() + there.root_from_eye(Eye::right).translation());
    carried_m_s += vor_ * head_rad_s_.cross(fixation.point_m - between);
  }
  if (!body_.is_zero())
    carried_m_s +=
        here.leftCols<torso_joint_count>() * body_.torso_rad_s + body_.base_rad_s.cross(fixation.point_m);
  return {by_eyes(there.fixation_jacobian(), eye_gain_per_s * (*target_m_ - fixation.point_m)),
          -by_eyes(here, carried_m_s)};
}

IkinGazeController::EyeMotion IkinGazeController::left_eye(const JointVector& q) const {
  // Tilt and pan that turn the axis as `turn` (rad/s, root frame) does, whose part about the axis is of no use.
  const auto by_eye = [](const HeadKinematics& head, const Eigen::Vector3d& turn) -> Eigen::Vector2d {
    const Eigen::Vector3d axis = head.root_from_eye(Eye::left).linear().col(2);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    Eigen::Matrix<double, 3, 2> joints;
    joints << across * head.axis(eyes_tilt), across * head.axis(eyes_version);
    return least_norm_solution(joints, across * turn);
  };
  JointVector planned = q;
  planned.segment<3>(eyes_tilt) = goal_rad_.segment<3>(neck_joint_count);
  const HeadKinematics there(limits_.head->chain, planned);
  const Eigen::Isometry3d& eye = there.root_from_eye(Eye::left);
  const Eigen::Vector3d to_target = *target_m_ - eye.translation();
  const Eigen::Vector3d axis = eye.linear().col(2);
  const Eigen::Vector3d turn = axis.cross(to_target).stableNormalized() * angle_between(axis, to_target);
  const Eigen::Vector2d wanted = eye_gain_per_s * by_eye(there, turn);

  const HeadKinematics here(limits_.head->chain, q);
  const EyeJacobian jacobian = here.jacobian(Eye::left);
  const Eigen::Vector3d neck_rad_s = ocr_ * velocity_rad_s_.head<neck_joint_count>();
  Eigen::Vector3d turned = jacobian.angular.middleCols<neck_joint_count>(neck_pitch) * neck_rad_s;
  if (vor_ != 0.0) turned += vor_ * head_rad_s_;
  const Eigen::Vector3d moved = jacobian.linear.middleCols<neck_joint_count>(neck_pitch) * neck_rad_s;
  const Eigen::Vector3d looks = here.root_from_eye(Eye::left).linear().col(2);
  const Eigen::Vector2d counter = by_eye(here, -turned - looks.cross(moved) / to_target.norm());

  const double vergence_rad_s =
      eye_gain_per_s * (neutral_rad_[head_index(eyes_vergence)] - goal_rad_[head_index(eyes_vergence)]);
  return {{wanted[0], wanted[1] - vergence_rad_s / 2, vergence_rad_s}, {counter[0], counter[1], 0.0}};
}

IkinGazeController::Eyes IkinGazeController::eyes_on_target(const JointVector& q) const {
  const CyclopeanEye eye(limits_.head->chain, q);
  const Eigen::Vector3d p = eye.see(*target_m_);
  const double ahead = std::hypot(p.y(), p.z());
  const double left = std::atan2(p.x() + eye.half_baseline_m(), ahead);
  const double right = std::atan2(p.x() - eye.half_baseline_m(), ahead);
  const double tilt_rad = -std::atan2(p.y(), std::abs(p.z()));
  if (both_eyes_) return inside_limits({tilt_rad, (left + right) / 2, left - right});
  return inside_limits({tilt_rad, left - neutral_rad_[head_index(eyes_vergence)] / 2,
                        neutral_rad_[head_index(eyes_vergence)]});
}

IkinGazeController::Eyes IkinGazeController::inside_limits(const Eyes& eyes_rad) const {
  return eyes_rad.cwiseMax(limits_.min_rad.segment<3>(neck_joint_count))
      .cwiseMin(limits_.max_rad.segment<3>(neck_joint_count));
}

void IkinGazeController::integrate(const HeadJointVector& q, double dt) {
  for (int j = 0; j < head_joint_count; ++j) {
    const double before = reference_rad_[j];
    const VelocityRange range = allowed_velocity(limits_, j, before, velocity_rad_s_[j], dt);
    double velocity;
    if (saccade_ && j >= neck_joint_count) {
      const double left = goal_rad_[j] - before;
      velocity = std::copysign(stoppable_speed(std::abs(left), limits_.acceleration_rad_s2[j], dt), left);
    } else {
      velocity = wanted_rad_s_[j];
      const double lead = before - q[j];
      if (std::abs(lead) > max_lead_rad && lead * velocity > 0.0) velocity = 0.0;
    }
    velocity = std::clamp(velocity, range.min, range.max);
    reference_rad_[j] = std::clamp(before + velocity * dt, std::min(before, limits_.min_rad[j]),
                                   std::max(before, limits_.max_rad[j]));
    velocity_rad_s_[j] = (reference_rad_[j] - before) / dt;
  }
  if (!saccade_) {
    const Eyes moved = goal_rad_.segment<3>(neck_joint_count) +
                       dt * (goal_velocity_rad_s_ + counter_rad_s_).segment<3>(neck_joint_count);
    goal_rad_.segment<3>(neck_joint_count) = inside_limits(moved);
  }
}

}  // namespace saccade
