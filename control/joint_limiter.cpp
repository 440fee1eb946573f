#include "control/joint_limiter.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/units.h"

namespace saccade {
namespace {

constexpr double arrived_rad = 1e-12;  // rounding

}  // namespace

void describe(FieldVisitor& v, MotionLimitsConfig& config) {
  v.real("margin_deg", config.margin_deg, {0.0, 10.0}, "distance of references from the position limits");
  v.real("neck_speed_deg_s", config.neck_speed_deg_s, {1.0, 1000.0}, "highest speed of the neck joints");
  v.real("eye_speed_deg_s", config.eye_speed_deg_s, {1.0, 1000.0},
         "highest speed of tilt, version, vergence");
  v.real("neck_acceleration_deg_s2", config.neck_acceleration_deg_s2, {10.0, 1e6},
         "highest acceleration of the neck joints");
  v.real("eye_acceleration_deg_s2", config.eye_acceleration_deg_s2, {10.0, 1e6},
         "highest acceleration of tilt, version, vergence");
}

MotionLimits motion_limits(const JointLimits& hardware, const MotionLimitsConfig& config) {
  check_config("gaze.limits", config);
  const HeadModel& head = *hardware.head;
  MotionLimits limits;
  limits.head = hardware.head;
  limits.joints = head.gaze_joints();
  const int neck = head.neck_joints();
  const int eyes = limits.joints - neck;
  limits.hardware_min_rad = hardware.min_rad.tail<gaze_slots>();
  limits.hardware_max_rad = hardware.max_rad.tail<gaze_slots>();
  limits.min_rad = limits.hardware_min_rad.array() + config.margin_deg * rad_per_deg;
  limits.max_rad = limits.hardware_max_rad.array() - config.margin_deg * rad_per_deg;
  limits.speed_rad_s.setZero();
  limits.speed_rad_s.head(neck).setConstant(config.neck_speed_deg_s * rad_per_deg);
  limits.speed_rad_s.segment(neck, eyes).setConstant(config.eye_speed_deg_s * rad_per_deg);
  limits.speed_rad_s = limits.speed_rad_s.cwiseMin(hardware.max_speed_rad_s.tail<gaze_slots>());
  limits.acceleration_rad_s2.setZero();
  limits.acceleration_rad_s2.head(neck).setConstant(config.neck_acceleration_deg_s2 * rad_per_deg);
  limits.acceleration_rad_s2.segment(neck, eyes).setConstant(config.eye_acceleration_deg_s2 * rad_per_deg);
  for (HeadJointVector* unused :
       {&limits.hardware_min_rad, &limits.hardware_max_rad, &limits.min_rad, &limits.max_rad}) {
    unused->tail(gaze_slots - limits.joints).setZero();
  }
  std::vector<Problem> problems;
  for (int j = 0; j < limits.joints; ++j) {
    if (limits.min_rad[j] < limits.max_rad[j] && limits.speed_rad_s[j] > 0.0) continue;
    problems.push_back({"limits of " + std::string(head.name_of(torso_slots + j)),
                        "[" + text_of(limits.min_rad[j]) + ", " + text_of(limits.max_rad[j]) + "] rad, " +
                            text_of(limits.speed_rad_s[j]) + " rad/s",
                        "a range that the margin leaves open and a speed above 0"});
  }
  if (!problems.empty()) throw InputError(problems);
  return limits;
}

// d / (n dt) + a dt (n - 1) / 2 with the least n steps that suffice.
double stoppable_speed(double distance, double acceleration, double dt) {
  if (!(distance > 0.0)) return 0.0;
  const double per_step = acceleration * dt * dt;
  const double steps = std::max(1.0, std::ceil((std::sqrt(1.0 + 8.0 * distance / per_step) - 1.0) / 2));
  return distance / (steps * dt) + acceleration * dt * (steps - 1.0) / 2;
}

VelocityRange allowed_velocity(const MotionLimits& limits, int joint, double position, double velocity,
                               double dt, double speed_share) {
  const double a = limits.acceleration_rad_s2[joint];
  const double up = stoppable_speed(limits.max_rad[joint] - position, a, dt);
  const double down = -stoppable_speed(position - limits.min_rad[joint], a, dt);
  const double speed = speed_share * limits.speed_rad_s[joint];
  const double fastest =
      std::clamp(std::max(std::min(speed, velocity + a * dt), velocity - a * dt), down, up);
  const double slowest =
      std::clamp(std::min(std::max(-speed, velocity - a * dt), velocity + a * dt), down, up);
  return {slowest, fastest};
}

JointLimiter::Result JointLimiter::apply(const HeadJointVector& command, const HeadJointVector& measured,
                                         double dt_s, double speed_share) {
  SACCADE_CHECK(dt_s > 0.0 && speed_share >= 0.0 && speed_share <= 1.0);
  const double dt = bounded_step_s(dt_s);
  if (!started_) {
    reference_rad_ = inside_hardware(limits_, measured);
    command_rad_ = reference_rad_;
    started_ = true;
  }
  Result result;
  result.not_finite = !command.allFinite();
  const HeadJointVector asked = result.not_finite ? command_rad_ : command;
  for (int j = 0; j < limits_.joints; ++j) {
    const auto bit = static_cast<std::size_t>(j);
    const double goal = std::clamp(asked[j], limits_.min_rad[j], limits_.max_rad[j]);
    result.position[bit] = goal != asked[j];

    // Moves with the command and closes what is left between them no faster than it could stop there.
    const double lag = command_rad_[j] - reference_rad_[j];
    const double close =
        std::copysign(stoppable_speed(std::abs(lag), limits_.acceleration_rad_s2[j], dt), lag);
    const double wanted = (goal - command_rad_[j]) / dt + close;
    const VelocityRange range =
        allowed_velocity(limits_, j, reference_rad_[j], velocity_rad_s_[j], dt, speed_share);
    const double speed = speed_share * limits_.speed_rad_s[j];
    double velocity = wanted;
    if (std::abs(velocity) > speed * (1.0 + 1e-9)) {
      result.speed.set(bit);
      velocity = std::copysign(speed, velocity);
    }
    const double slack = 1e-9 * limits_.acceleration_rad_s2[j] * dt;  // what rounding makes of a fair command
    if (velocity < range.min - slack || velocity > range.max + slack) {
      result.acceleration.set(bit);
      velocity = std::clamp(velocity, range.min, range.max);
    }
    const double before = reference_rad_[j];
    double next = before + velocity * dt;
    if (std::abs(next - goal) < arrived_rad) next = goal;
    reference_rad_[j] =
        std::clamp(next, std::min(before, limits_.min_rad[j]), std::max(before, limits_.max_rad[j]));
    velocity_rad_s_[j] = (reference_rad_[j] - before) / dt;
    command_rad_[j] = goal;
  }
  result.reference_rad = reference_rad_;
  return result;
}

HeadJointVector inside_hardware(const MotionLimits& limits, const HeadJointVector& q) {
  HeadJointVector inside = HeadJointVector::Zero();
  for (int j = 0; j < limits.joints; ++j) {
    inside[j] =
        std::clamp(std::isfinite(q[j]) ? q[j] : 0.0, limits.hardware_min_rad[j], limits.hardware_max_rad[j]);
  }
  return inside;
}

}  // namespace saccade
