#include "robot/joint_board.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "head/minimum_jerk.h"

namespace saccade {

JointBoard::JointBoard(const std::vector<Joint>& joints, const Eigen::VectorXd& position_rad, bool movable)
    : reference_rad_(position_rad), movable_(movable) {
  SACCADE_CHECK(position_rad.size() == static_cast<Eigen::Index>(joints.size()));
  for (const Joint& joint : joints) {
    Axis axis{.joint = joint, .mode = movable ? JointMode::position : JointMode::idle};
    axis.measured_rad = position_rad[static_cast<Eigen::Index>(axes_.size())];
    axis.hold();
    axes_.push_back(axis);
  }
}

const JointBoard::Axis& JointBoard::at(int j) const {
  SACCADE_CHECK(j >= 0 && j < size());
  return axes_[static_cast<std::size_t>(j)];
}

JointBoard::Axis& JointBoard::at(int j) {
  SACCADE_CHECK(j >= 0 && j < size());
  return axes_[static_cast<std::size_t>(j)];
}

void JointBoard::Axis::hold() {
  reference_rad = std::clamp(measured_rad, joint.min_rad, joint.max_rad);
  target_rad = reference_rad;
  moving = false;
  wanted_rad_s = now_rad_s = 0.0;
}

void JointBoard::Axis::step(double dt_s) {
  if (moving) {
    const double before = move_s > 0.0 ? minimum_jerk(moved_s / move_s) : 0.0;
    moved_s += dt_s;
    moving = moved_s < move_s;
    const double after = moving ? minimum_jerk(moved_s / move_s) : 1.0;
    reference_rad = mode == JointMode::mixed ? reference_rad + (after - before) * (target_rad - from_rad)
                                             : from_rad + after * (target_rad - from_rad);
  }
  if (takes_velocities()) {
    since_velocity_s += dt_s;
    if (since_velocity_s > velocity_timeout_s) wanted_rad_s = 0.0;
    const double change = acceleration_rad_s2 * dt_s;
    now_rad_s = std::clamp(wanted_rad_s, now_rad_s - change, now_rad_s + change);
    const double next_rad = reference_rad + now_rad_s * dt_s;
    reference_rad = std::clamp(next_rad, joint.min_rad, joint.max_rad);
    if (reference_rad != next_rad) now_rad_s = 0.0;
  }
}

bool JointBoard::set_mode(int j, JointMode mode) {
  if (!movable_) return mode == JointMode::idle;
  Axis& axis = at(j);
  if (axis.mode == mode) return true;
  axis.mode = mode;
  axis.hold();
  return true;
}

bool JointBoard::move_to(int j, double position_rad) {
  Axis& axis = at(j);
  if ((axis.mode != JointMode::position && axis.mode != JointMode::mixed) || !std::isfinite(position_rad))
    return false;
  axis.from_rad = axis.reference_rad;
  axis.target_rad = std::clamp(position_rad, axis.joint.min_rad, axis.joint.max_rad);
  axis.move_s = std::abs(axis.target_rad - axis.from_rad) / axis.speed_rad_s;
  axis.moved_s = 0.0;
  axis.moving = true;
  return true;
}

bool JointBoard::set_speed(int j, double speed_rad_s) {
  if (!std::isfinite(speed_rad_s) || speed_rad_s <= 0.0) return false;
  at(j).speed_rad_s = std::min(speed_rad_s, at(j).joint.max_speed_rad_s);
  return true;
}

bool JointBoard::set_acceleration(int j, double acceleration_rad_s2) {
  if (!std::isfinite(acceleration_rad_s2) || acceleration_rad_s2 <= 0.0) return false;
  at(j).acceleration_rad_s2 = acceleration_rad_s2;
  return true;
}

bool JointBoard::set_reference(int j, double position_rad) {
  Axis& axis = at(j);
  if (axis.mode != JointMode::direct || !std::isfinite(position_rad)) return false;
  axis.reference_rad = std::clamp(position_rad, axis.joint.min_rad, axis.joint.max_rad);
  return true;
}

bool JointBoard::set_velocity(int j, double velocity_rad_s) {
  Axis& axis = at(j);
  if (!axis.takes_velocities() || !std::isfinite(velocity_rad_s)) return false;
  axis.wanted_rad_s = std::clamp(velocity_rad_s, -axis.joint.max_speed_rad_s, axis.joint.max_speed_rad_s);
  axis.since_velocity_s = 0.0;
  return true;
}

void JointBoard::stop(int j) { at(j).hold(); }

const Eigen::VectorXd& JointBoard::step(const Eigen::VectorXd& measured_rad, double dt_s) {
  SACCADE_CHECK(measured_rad.size() == reference_rad_.size() && dt_s >= 0.0);
  for (int j = 0; j < size(); ++j) {
    Axis& axis = at(j);
    if (std::isfinite(measured_rad[j])) axis.measured_rad = measured_rad[j];
    axis.step(dt_s);
    reference_rad_[j] = axis.reference_rad;
  }
  return reference_rad_;
}

}  // namespace saccade
