#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <vector>

#include "core/config.h"
#include "core/random.h"
#include "head/head_state.h"

namespace saccade {

/// Non-ideal behaviour of drives between motor and joint, the same for all joints of a group.
struct DriveConfig {
  double friction_share = 0.0;  ///< Coulomb friction, as a share of the servo's largest torque
  double backlash_deg = 0.0;    ///< rotation of a motor on reversal before its joint follows
};

/// Keys: friction_share, backlash_deg.
void describe(FieldVisitor& v, DriveConfig& config);

/// Errors of the encoders at the motors.
struct EncoderConfig {
  double noise_deg = 0.0;         ///< standard deviation, new at every millisecond
  double quantisation_deg = 0.0;  ///< step of the readings; 0: none
  /// Velocities are differences of readings over this time, as in firmware, so they lag by half of it. Encoders without
  /// noise and quantisation give the true velocity of the instant.
  std::int64_t velocity_window_ms = 10;
};

/// Keys: noise_deg, quantisation_deg, velocity_window_ms.
void describe(FieldVisitor& v, EncoderConfig& config);

/// Position of the neck's axes.
enum class NeckAxes {
  dh,  ///< those of iKin
  cad,  ///< neck pitch and yaw turn 5.31 mm further forward, pitch and roll 0.503 mm lower, as in iCubGenova02's CAD
};
constexpr auto words_of(NeckAxes) {
  return std::to_array<Word<NeckAxes>>({{NeckAxes::dh, "dh"}, {NeckAxes::cad, "cad"}});
}

/// Differences between the simulated plant and the model that gaze control uses. By default there are none.
struct PlantConfig {
  /// With all joints at 0 every body is at the same place with either.
  NeckAxes axes = NeckAxes::dh;
  EncoderConfig encoders;
  std::int64_t command_delay_ms = 0;  ///< delay from a command to the servos
  DriveConfig neck;
  DriveConfig eyes;
};

/// Keys: axes, encoders.*, command_delay_ms, neck.*, eyes.*.
void describe(FieldVisitor& v, PlantConfig& config);

/// Moves the anchors of the neck's joints in the model to the CAD chain. Masses and shapes stay in place.
void move_neck_axes_to_cad(mjModel& model);

/// Sets the Coulomb friction of a hinge, N m.
void set_friction(mjModel& model, int joint, double friction_nm);

/// Position of a joint behind a drive with backlash: it rests until its motor has crossed the gap. (Friction holds it;
/// motion of the joint inside the gap is not modelled.)
[[nodiscard]] double joint_behind_backlash(double motor_rad, double joint_rad,
                                           double backlash_half_width_rad);

/// The encoders at the motors of the plant's joints, each with noise of its own.
class Encoders {
 public:
  /// The motors have been at `position_rad` for longer than the velocity window. Throws InputError for a config out of
  /// range.
  Encoders(const EncoderConfig& config, std::uint64_t seed, const JointVector& position_rad);

  /// Takes a reading from the true state of the motors. Call once per millisecond.
  void read(const JointVector& position_rad, const JointVector& velocity_rad_s);
  [[nodiscard]] const JointVector& position_rad() const { return position_rad_; }
  [[nodiscard]] const JointVector& velocity_rad_s() const { return velocity_rad_s_; }

 private:
  [[nodiscard]] JointVector reading(const JointVector& position_rad) const;

  EncoderConfig config_;
  RandomStream random_;
  std::uint64_t count_ = 0;            // of readings
  std::vector<JointVector> readings_;  // of the velocity window, a ring
  JointVector position_rad_ = JointVector::Zero();
  JointVector velocity_rad_s_ = JointVector::Zero();
};

}  // namespace saccade
