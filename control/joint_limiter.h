#pragma once

#include <bitset>

#include "core/config.h"
#include "head/head_state.h"

namespace saccade {

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

/// What a reference of the six head joints may be and do.
struct MotionLimits {
  HeadJointVector min_rad, max_rad;  ///< where references go: inside the hardware by the margin
  HeadJointVector hardware_min_rad, hardware_max_rad;
  HeadJointVector speed_rad_s;  ///< the smaller of the configuration's and the hardware's
  HeadJointVector acceleration_rad_s2;
};

/// Throws InputError for a bad configuration, and where the margin leaves a joint no range.
[[nodiscard]] MotionLimits motion_limits(const JointLimits& hardware, const MotionLimitsConfig& config);

/// The highest speed from which a reference that moves in steps of dt_s, losing at most acceleration * dt_s per
/// step, stops within `distance_rad`; 0 for none. rad/s.
[[nodiscard]] double stoppable_speed(double distance_rad, double acceleration_rad_s2, double dt_s);

/// The velocities a reference at `position` that moves at `velocity` may take for the next dt_s such that it
/// keeps the speed and acceleration limits and can always stop before min or max. Outside of these only
/// inward. Never empty; where the limits contradict each other (a start at high speed near a stop) position
/// comes first, then acceleration. `speed_share` in [0, 1] of the speed limits is allowed.
struct VelocityRange {
  double min;
  double max;
};
[[nodiscard]] VelocityRange allowed_velocity(const MotionLimits& limits, int joint, double position_rad,
                                             double velocity_rad_s, double dt_s, double speed_share = 1.0);

using JointMask = std::bitset<head_joint_count>;  ///< bit j: head joint j, neck pitch first

/// The last stage before the robot, whoever commands: holds any stream of references within the limits of
/// position, speed and acceleration, and says which limit acted on which joint.
///
/// A stream within the limits passes unchanged. A jump becomes a swift move that stops at its end without
/// overshoot. Starts at the measured joints, moved into the hardware's limits where they are outside, and
/// goes from there to the range of MotionLimits under the same limits of speed and acceleration.
class JointLimiter {
 public:
  struct Result {
    HeadJointVector reference_rad =
        HeadJointVector::Zero();  ///< always finite and within the hardware's limits
    JointMask position;           ///< the command was outside the position limits
    JointMask speed;              ///< it asked for more speed
    JointMask acceleration;       ///< it asked for more acceleration, braking before a limit included
    bool not_finite = false;      ///< NaN or infinite somewhere: the last finite command holds for all joints
  };

  explicit JointLimiter(const MotionLimits& limits) : limits_(limits) {}

  /// `measured_rad` is looked at in the first call only; dt_s > 0 is the time since the last call. `speed_share` in
  /// [0, 1]: of the speed limits, for a head that shall start slowly.
  Result apply(const HeadJointVector& command_rad, const HeadJointVector& measured_rad, double dt_s,
               double speed_share = 1.0);

 private:
  MotionLimits limits_;
  bool started_ = false;
  HeadJointVector command_rad_ = HeadJointVector::Zero();
  HeadJointVector reference_rad_ = HeadJointVector::Zero();
  HeadJointVector velocity_rad_s_ = HeadJointVector::Zero();
};

/// `q` where it is finite, moved into the hardware's limits; the value nearest to 0 in there where it is not.
[[nodiscard]] HeadJointVector inside_hardware(const MotionLimits& limits, const HeadJointVector& q);

}  // namespace saccade
