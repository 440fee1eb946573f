#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "core/config.h"
#include "head/head_model.h"
#include "head/head_state.h"
#include "head/imu_reading.h"

namespace saccade {

/// Which measurements of the body's motion the eyes compensate at once, before the target's image has moved.
struct StabilisationConfig {
  bool torso = false;      ///< velocities of the torso's joints
  bool gyroscope = false;  ///< angular velocity of the head (vestibulo-ocular reflex)
};

/// Keys: torso, gyroscope.
void describe(FieldVisitor& v, StabilisationConfig& config);

/// Motion of the body below the neck that the eyes compensate.
struct BodyRates {
  Eigen::Vector3d torso_rad_s = Eigen::Vector3d::Zero();  ///< of the torso's joints
  Eigen::Vector3d base_rad_s = Eigen::Vector3d::Zero();   ///< of a rotation about the root, root frame
  /// Rotation of the base since the start: from the root frame to one that does not turn with it.
  Eigen::Quaterniond level_from_root = Eigen::Quaterniond::Identity();

  [[nodiscard]] bool is_zero() const { return torso_rad_s.isZero(0.0) && base_rad_s.isZero(0.0); }
};

/// Computes BodyRates from encoders and the inertial measurement unit.
///
/// What the gyroscope measures less what neck and torso turn is the rotation of the base, which is taken to be about the
/// root. With `gyroscope` alone base_rad_s includes the rotation of the torso, as if it were about the root. Velocities are
/// extrapolated by the delay of the eyes (first-order, derivative over 10 ms). level_from_root is integrated; a bias of the
/// gyroscope lets it drift, which looks like a slow motion of all targets.
class Stabiliser {
 public:
  /// `head`: not null.
  Stabiliser(const StabilisationConfig& config, std::shared_ptr<const HeadModel> head);

  /// Call once per tick. `state`: finite. `imu`: the newest reading, or null. `eyes_s`: delay of the eyes.
  const BodyRates& update(const HeadState& state, const ImuReading* imu, double eyes_s, double dt_s);

 private:
  /// A velocity and its derivative.
  struct Filtered {
    Eigen::Vector3d slow = Eigen::Vector3d::Zero();
    Eigen::Vector3d ahead(const Eigen::Vector3d& now, double lead_s, double dt_s);
  };
  StabilisationConfig config_;
  std::shared_ptr<const HeadModel> head_;
  Eigen::Matrix3d eye_from_root_at_zero_;
  BodyRates rates_;
  Filtered torso_, base_;
};

}  // namespace saccade
