#pragma once

#include <Eigen/Core>
#include <optional>

#include "control/head_kinematics.h"
#include "core/config.h"

namespace saccade {

/// Small deliberate eye movements while a ball at rest makes no events.
struct FixationalConfig {
  double amplitude_deg = 0.0;  ///< half the width of the movement; 0: none
  double after_s =
      0.5;  ///< time without a detection from current events until a movement, and between two of them
  double frequency_hz = 2.0;  ///< a movement lasts one period
};

/// Keys: amplitude_deg, after_s, frequency_hz.
void describe(FieldVisitor& v, FixationalConfig& config);

/// When the gaze moves around the target, and where to. One movement is an ellipse through the target: to the right
/// amplitude sin(2 pi f t), up amplitude (1 - cos(2 pi f t)) / 2.
class FixationalMovement {
 public:
  /// Throws InputError for a configuration out of range.
  explicit FixationalMovement(const FixationalConfig& config);

  /// Call once per tick. `seen`: the driving detector reports the ball from current events, not held. `follows`: there is a
  /// target. Returns the angles by which the gaze leaves the target, to the right and up, rad; none while it stays.
  std::optional<Eigen::Vector2d> update(bool seen, bool follows, double dt_s);

 private:
  FixationalConfig config_;
  double unseen_s_ = 0.0;
  std::optional<double> moving_s_;  ///< since the start of the movement
};

/// The point at the distance of `target_m` (root frame) that the left eye sees away from it by these angles, rad.
[[nodiscard]] Eigen::Vector3d displaced(const Eigen::Vector3d& target_m, const Eigen::Vector2d& right_up_rad,
                                        const HeadKinematics& head);

}  // namespace saccade
