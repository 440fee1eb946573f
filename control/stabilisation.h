#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/config.h"
#include "head/head_model.h"
#include "head/head_state.h"
#include "head/imu_reading.h"

namespace saccade {

/// Which measurements of the body's motion the eyes compensate at once, before the target's image has moved.
struct StabilisationConfig {
  bool torso = false;      ///< velocities of the torso's joints
  bool gyroscope = false;  ///< angular velocity of the head (vestibulo-ocular reflex)
  bool image = false;      ///< rotation of the camera that the whole image shows (optokinetic reflex)

  [[nodiscard]] bool any() const { return torso || gyroscope || image; }
};

/// Keys: torso, gyroscope, image.
void describe(FieldVisitor& v, StabilisationConfig& config);

/// Motion of the body below the neck that the eyes compensate.
struct BodyRates {
  Eigen::Vector3d torso_rad_s = Eigen::Vector3d::Zero();  ///< of the torso's joints
  Eigen::Vector3d base_rad_s = Eigen::Vector3d::Zero();   ///< of a rotation about the root, root frame
  /// Rotation of the base since the start: from the root frame to one that does not turn with it.
  Eigen::Quaterniond level_from_root = Eigen::Quaterniond::Identity();

  [[nodiscard]] bool is_zero() const { return torso_rad_s.isZero(0.0) && base_rad_s.isZero(0.0); }
};

/// Computes BodyRates from encoders, the inertial measurement unit and the image.
///
/// What the gyroscope measures less what neck and torso turn is the rotation of the base, which is taken to be about the
/// root. With `gyroscope` alone base_rad_s includes the rotation of the torso, as if it were about the root. Velocities are
/// extrapolated by the delay of the eyes (first-order, derivative over 10 ms). level_from_root is integrated; a bias of the
/// gyroscope lets it drift, which looks like a slow motion of all targets.
///
/// What the image shows (ImageRotation) less what neck and eyes turn, and less what torso and gyroscope already
/// compensate, is added with a time constant of 12 ms, at most 60 deg/s of it. It is older than 8 ms (docs/oculomotor.md) and is not
/// extrapolated.
/// Without a measurement for 50 ms it fades within 0.1 s.
class Stabiliser {
 public:
  /// `head`: not null. `eye_from_camera`: of the left eye's camera, whose image is used.
  Stabiliser(const StabilisationConfig& config, std::shared_ptr<const HeadModel> head,
             const Eigen::Isometry3d& eye_from_camera = Eigen::Isometry3d::Identity());

  /// Call once per tick. `state`: finite. `imu`: the newest reading, or null. `eyes_s`: delay of the eyes. `seen_rad_s`: a new
  /// result of ImageRotation, camera frame.
  const BodyRates& update(const HeadState& state, const ImuReading* imu, double eyes_s, double dt_s,
                          const std::optional<Eigen::Vector3d>& seen_rad_s = std::nullopt);

 private:
  /// A velocity and its derivative.
  struct Filtered {
    Eigen::Vector3d slow = Eigen::Vector3d::Zero();
    Eigen::Vector3d ahead(const Eigen::Vector3d& now, double lead_s, double dt_s);
  };
  /// Rotations of one tick, root frame.
  struct Explained {
    Eigen::Vector3d by_head = Eigen::Vector3d::Zero();  ///< by neck and eyes
    Eigen::Vector3d by_torso = Eigen::Vector3d::Zero();
    Eigen::Vector3d by_base = Eigen::Vector3d::Zero();  ///< as the gyroscope has it
  };
  void turn_level(const Eigen::Vector3d& base_rad_s, double dt_s);
  void use_gyroscope(const HeadState& state, const ImuReading& imu, double eyes_s, double dt_s);
  void use_image(const HeadState& state, const std::optional<Eigen::Vector3d>& seen_rad_s, double dt_s);

  StabilisationConfig config_;
  std::shared_ptr<const HeadModel> head_;
  Eigen::Matrix3d eye_from_root_at_zero_;
  Eigen::Matrix3d eye_from_camera_;
  BodyRates rates_;
  Eigen::Vector3d measured_base_rad_s_ = Eigen::Vector3d::Zero();  ///< by the gyroscope, in this tick
  Filtered torso_, base_;
  std::array<Explained, 16> explained_;  ///< of the last milliseconds, a ring: the window of ImageRotation
  std::size_t ticks_ = 0;
  Eigen::Vector3d seen_all_ = Eigen::Vector3d::Zero();   ///< not compensated otherwise
  Eigen::Vector3d seen_base_ = Eigen::Vector3d::Zero();  ///< of it, not the torso's
  double unseen_s_ = 0.0;
};

}  // namespace saccade
