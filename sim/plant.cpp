#include "sim/plant.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace saccade {
namespace {

constexpr double tick_s = 1e-3;

}  // namespace

void describe(FieldVisitor& v, DriveConfig& c) {
  v.real("friction_share", c.friction_share, {0.0, 0.5},
         "Coulomb friction, as a share of the servo's largest torque");
  v.real("backlash_deg", c.backlash_deg, {0.0, 5.0},
         "rotation of the motor on reversal before its joint follows");
}

void describe(FieldVisitor& v, EncoderConfig& c) {
  v.real("noise_deg", c.noise_deg, {0.0, 1.0}, "standard deviation of a reading, new every millisecond");
  v.real("quantisation_deg", c.quantisation_deg, {0.0, 1.0}, "step of the readings; 0: none");
  v.integer("velocity_window_ms", c.velocity_window_ms, {1, 100},
            "time over which readings are differenced if they are noisy or quantised");
}

void describe(FieldVisitor& v, PlantConfig& c) {
  v.choice("axes", c.axes, "axes of the neck: iKin's chain or the CAD's");
  v.section("encoders", c.encoders, "errors of the encoders at the motors");
  v.integer("command_delay_ms", c.command_delay_ms, {0, 200}, "delay from a command to the servos");
  v.section("neck", c.neck, "drives of neck pitch, roll and yaw");
  v.section("eyes", c.eyes, "drives of the eyes' tilt and pans");
}

void move_neck_axes_to_cad(mjModel& model) {
  // URDF of iCubGenova02 (icub-models): torso_pitch to neck_yaw, summed up in the root frame, against iKin's
  // v2 chain. Neck roll turns about x, so its place along x has no effect.
  constexpr double forward_m = 0.0108093 - 0.0055;
  constexpr double lower_m = 0.2553 - 0.254797;
  for (const char* name : {"neck_pitch", "neck_roll", "neck_yaw"}) {
    mjtNum* anchor = model.jnt_pos + 3 * mj_name2id(&model, mjOBJ_JOINT, name);
    anchor[0] -= forward_m;
    anchor[2] -= lower_m;
  }
}

void set_friction(mjModel& model, int joint, double friction_nm) {
  const int dof = model.jnt_dofadr[joint];
  model.dof_frictionloss[dof] = friction_nm;
  // As stiff as MuJoCo permits, so that a sticking joint does not creep.
  model.dof_solref[mjNREF * dof] = 2.0 * model.opt.timestep;
  model.dof_solimp[mjNIMP * dof] = model.dof_solimp[mjNIMP * dof + 1] = mjMAXIMP;
}

double joint_behind_backlash(double motor_rad, double joint_rad, double backlash_half_width_rad) {
  return std::clamp(joint_rad, motor_rad - backlash_half_width_rad, motor_rad + backlash_half_width_rad);
}

Encoders::Encoders(const EncoderConfig& config, std::uint64_t seed, const JointVector& position_rad)
    : config_(config), random_(seed, "sim/plant/encoders") {
  check_config("plant.encoders", config);
  position_rad_ = reading(position_rad);
  readings_.assign(static_cast<std::size_t>(config.velocity_window_ms), position_rad_);
}

JointVector Encoders::reading(const JointVector& position_rad) const {
  JointVector reading_rad = position_rad;
  for (int j = 0; j < joint_count; ++j) {
    if (config_.noise_deg > 0.0) {
      reading_rad[j] +=
          config_.noise_deg * rad_per_deg * random_.normal(static_cast<std::uint64_t>(j), count_);
    }
    if (config_.quantisation_deg > 0.0) {
      const double step_rad = config_.quantisation_deg * rad_per_deg;
      reading_rad[j] = step_rad * std::round(reading_rad[j] / step_rad);
    }
  }
  return reading_rad;
}

void Encoders::read(const JointVector& position_rad, const JointVector& velocity_rad_s) {
  ++count_;
  position_rad_ = reading(position_rad);
  velocity_rad_s_ = velocity_rad_s;
  if (!(config_.noise_deg > 0.0 || config_.quantisation_deg > 0.0)) return;
  JointVector& oldest_rad = readings_[count_ % readings_.size()];
  velocity_rad_s_ = (position_rad_ - oldest_rad) / (tick_s * static_cast<double>(readings_.size()));
  oldest_rad = position_rad_;
}

}  // namespace saccade
