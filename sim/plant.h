#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/config.h"
#include "core/random.h"
#include "head/head_state.h"

namespace saccade {

/// What real drives do between motor and joint; the same for all joints of a group.
struct DriveConfig {
  double friction_share = 0.0;  ///< Coulomb friction, of the servo's largest torque
  double backlash_deg = 0.0;    ///< how far a motor turns on reversal before its joint follows
};

/// What the encoders make of where the motors are.
struct EncoderConfig {
  double noise_deg = 0.0;         ///< standard deviation, new at every millisecond
  double quantisation_deg = 0.0;  ///< readings are multiples of it; 0: none
  /// Velocities are the difference of the readings over so long, as firmware has them, and so are old by half
  /// of it. Encoders without noise and quantisation give the true velocity of the instant.
  std::int64_t velocity_window_ms = 10;
};

/// Keys: noise_deg, quantisation_deg, velocity_window_ms.
void describe(FieldVisitor& v, EncoderConfig& config);

/// How the plant differs from the model that gaze has of it. By default it does not.
struct PlantConfig {
  /// dh: the neck's axes are iKin's. cad: neck pitch and yaw turn 5.31 mm further forward, pitch and roll
  /// 0.503 mm lower, as iCubGenova02's CAD has them; with all joints at 0 nothing is elsewhere.
  std::string axes = "dh";
  EncoderConfig encoders;
  std::int64_t command_delay_ms = 0;  ///< from a command to the servos
  DriveConfig neck;
  DriveConfig eyes;
};

/// Keys: axes, encoders.*, command_delay_ms, neck.*, eyes.*.
void describe(FieldVisitor& v, PlantConfig& config);

/// Moves the anchors of the neck's joints in the model to the CAD chain. Masses and looks stay where they are.
void move_neck_axes_to_cad(mjModel& model);

/// Gives a hinge Coulomb friction of so many N m.
void set_friction(mjModel& model, int joint, double friction_nm);

/// The joint behind a drive with play: it rests until its motor has crossed the gap. (Its own friction holds
/// it; that it might swing in the gap is left out.)
[[nodiscard]] double behind_play(double motor_rad, double joint_rad, double half_play_rad);

/// Encoders of the plant's joints, each with its own noise. They sit at the motors.
class Encoders {
 public:
  /// Throws InputError. Motors that have always been at `position_rad`.
  Encoders(const EncoderConfig& config, std::uint64_t seed, const JointVector& position_rad);

  /// Where the motors are and how fast, once per millisecond.
  void read(const JointVector& position_rad, const JointVector& velocity_rad_s);
  [[nodiscard]] const JointVector& position_rad() const { return position_rad_; }
  [[nodiscard]] const JointVector& velocity_rad_s() const { return velocity_rad_s_; }

 private:
  [[nodiscard]] JointVector reading(const JointVector& position_rad) const;

  EncoderConfig config_;
  RandomStream random_;
  std::uint64_t count_ = 0;            // of readings
  std::vector<JointVector> readings_;  // of the velocity window, a ring
  JointVector position_rad_;
  JointVector velocity_rad_s_ = JointVector::Zero();
};

}  // namespace saccade
