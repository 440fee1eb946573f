#pragma once

#include <algorithm>
#include <bitset>

#include "core/config.h"
#include "head/head_model.h"
#include "head/head_state.h"

namespace saccade {

/// Largest position, rad, and speed, rad/s, that count as a reading. Larger ones, such as those of a broken message, would
/// overflow in what is computed from them.
inline constexpr double largest_reading = 1e4;

/// Whether these are numbers that joints can have: finite and at most largest_reading.
template <class Vector>
[[nodiscard]] bool is_reading(const Eigen::MatrixBase<Vector>& values) {
  return values.allFinite() && values.cwiseAbs().maxCoeff() <= largest_reading;
}

/// The time step of a controller and of the limiter: at least 1 us, at most 1 s. The rest of a longer pause is left out.
[[nodiscard]] inline double bounded_step_s(double dt_s) { return std::clamp(dt_s, 1e-6, 1.0); }

/// How far inside the hardware's limits gaze stays, and how briskly it may move.
struct MotionLimitsConfig {
  double margin_deg = 0.05;  ///< references keep this far from the hardware's position limits
  double neck_speed_deg_s = 80.0;
  double eye_speed_deg_s = 350.0;
  double neck_acceleration_deg_s2 = 1000.0;
  double eye_acceleration_deg_s2 = 15000.0;
};

/// Keys: margin_deg, neck_speed_deg_s, eye_speed_deg_s, neck_acceleration_deg_s2, eye_acceleration_deg_s2.
void describe(FieldVisitor& v, MotionLimitsConfig& config);

/// Limits of position, speed and acceleration for the references of the joints that gaze commands.
struct MotionLimits {
  /// The head whose joints these are; never null. Of the vectors the first `joints` elements count, first the neck's.
  std::shared_ptr<const HeadModel> head = default_head();
  int joints = head_joint_count;
  HeadJointVector min_rad, max_rad;  ///< range of references: that of the hardware less the margin
  HeadJointVector hardware_min_rad, hardware_max_rad;
  HeadJointVector speed_rad_s;  ///< the smaller of the configuration's and the hardware's
  HeadJointVector acceleration_rad_s2;
};

/// Throws InputError for a configuration out of range, or if the margin leaves a joint no range.
[[nodiscard]] MotionLimits motion_limits(const JointLimits& hardware, const MotionLimitsConfig& config);

/// The highest speed from which a reference that moves in steps of dt_s, losing at most acceleration * dt_s per
/// step, stops within `distance_rad`; 0 for none. rad/s.
[[nodiscard]] double stoppable_speed(double distance_rad, double acceleration_rad_s2, double dt_s);

/// The velocities for the next dt_s of a reference at `position` that moves at `velocity`, within the limits of speed and
/// acceleration and such that it can stop before min and max. Outside of min and max only inward velocities are allowed.
/// Never empty: if limits contradict each other (high speed near a limit), position has priority, then acceleration.
/// `speed_share` in [0, 1] scales the limits of speed.
struct VelocityRange {
  double min;
  double max;
};
[[nodiscard]] VelocityRange allowed_velocity(const MotionLimits& limits, int joint, double position_rad,
                                             double velocity_rad_s, double dt_s, double speed_share = 1.0);

using JointMask = std::bitset<gaze_slots>;  ///< bit j: joint j of the gaze, the neck first

/// Restricts any stream of references to the limits of position, speed and acceleration. It is the last stage before the
/// robot, and reports which limit acted on which joint.
///
/// A stream within the limits passes unchanged. A step becomes a move at the limits, without overshoot. The first
/// reference starts at the measured joints, clamped to the limits of the hardware, and moves from there into the range of
/// MotionLimits.
class JointLimiter {
 public:
  struct Result {
    HeadJointVector reference_rad =
        HeadJointVector::Zero();  ///< always finite and within the hardware's limits
    JointMask position;           ///< the command was outside the position limits
    JointMask speed;              ///< the command exceeded the speed limit
    JointMask acceleration;       ///< or the acceleration limit, braking before a position limit included
    bool not_finite =
        false;  ///< an element is NaN or infinite: the last finite command is kept for all joints
  };

  explicit JointLimiter(const MotionLimits& limits) : limits_(limits) {}

  /// `measured_rad` is used in the first call only. dt_s: time since the last call, above 0. `speed_share` in [0, 1]
  /// scales the limits of speed, for a slow start.
  Result apply(const HeadJointVector& command_rad, const HeadJointVector& measured_rad, double dt_s,
               double speed_share = 1.0);

 private:
  MotionLimits limits_;
  bool started_ = false;
  HeadJointVector command_rad_ = HeadJointVector::Zero();
  HeadJointVector reference_rad_ = HeadJointVector::Zero();
  HeadJointVector velocity_rad_s_ = HeadJointVector::Zero();
};

/// Clamps `q` to the limits of the hardware. An element that is not finite becomes the allowed value nearest to 0.
[[nodiscard]] HeadJointVector inside_hardware(const MotionLimits& limits, const HeadJointVector& q);

}  // namespace saccade
