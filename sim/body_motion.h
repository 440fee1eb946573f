#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config.h"

namespace saccade {

/// An oscillation: amplitude sin(2 pi frequency t + phase).
struct SwayConfig {
  double amplitude_deg = 0.0;
  double frequency_hz = 0.5;
  double phase_deg = 0.0;
};

/// Keys: amplitude_deg, frequency_hz, phase_deg.
void describe(FieldVisitor& v, SwayConfig& config);

/// Motion of the robot's torso or base that gaze control does not command: walking, a push, a wheeled base.
struct BodyMotionConfig {
  double start_s = 0.0;  ///< before it the body rests
  double ramp_s = 0.5;   ///< time in which the motion grows to its full size
  SwayConfig pitch, roll, yaw;
  /// Recorded motion, added to the oscillations: a CSV file with the columns t_us,pitch_deg,roll_deg,yaw_deg and any
  /// others. Empty: none.
  std::string file;
};

/// Keys: start_s, ramp_s, pitch.*, roll.*, yaw.*, file.
void describe(FieldVisitor& v, BodyMotionConfig& config);

/// Pitch, roll and yaw over time: oscillations, and a recording with linear interpolation that holds its last value.
class BodyMotion {
 public:
  /// Throws InputError for a configuration out of range, and for a file that cannot be read or has a time that does not
  /// grow.
  explicit BodyMotion(const BodyMotionConfig& config);

  /// Pitch, roll, yaw, rad. Times before start_s give zero.
  [[nodiscard]] Eigen::Vector3d angles_rad(std::int64_t t_us) const;

 private:
  struct Sample {
    double t_s;
    Eigen::Vector3d angles_rad;
  };
  BodyMotionConfig config_;
  std::vector<Sample> samples_;
};

/// The rotation of a base by pitch (leans forward), roll (about x) and yaw (turns right), in the root frame (x backward,
/// y right, z up), pitch first: the signs of the torso's joints.
[[nodiscard]] Eigen::Quaterniond base_rotation(const Eigen::Vector3d& angles_rad);

}  // namespace saccade
