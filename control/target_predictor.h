#pragma once

#include <optional>

#include "control/periodic_fit.h"
#include "control/target_track.h"

namespace saccade {

/// Position and velocity of a target at one time.
struct TargetMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< root frame
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< root frame
};

/// Free flight from t0 on: position = velocity and place at t0 of 0, acceleration by gravity alone.
struct FreeFall {
  double t0_s = 0.0;
};

/// Predicts a gaze target from its last observations, which may be old.
///
/// The target's motion is split into a known motion and what is left of it. The known motion is a sinusoid (PeriodicFit) or
/// free fall, and none while neither fits; it is extrapolated exactly. A TargetTrack follows the rest, so that it lags
/// only behind the rest: without a known motion the estimate is that of the TargetTrack. When the known motion changes,
/// the track is shifted, so that the estimate is continuous.
///
/// A known motion is dropped when observations leave it: when the mean distance between observations and predictions over
/// 30 ms exceeds a quarter of its amplitude (free fall: 2 cm), or when no target came for TargetTrack::forget_s.
class TargetPredictor {
 public:
  /// `time_constant_s`: memory of the TargetTrack. `models`: whether known motions are used.
  TargetPredictor(double time_constant_s, bool models);

  void advance(double dt_s);
  /// Adds a target that was seen age_s before the current time of advance(). Finite, m, root frame.
  void observe(const Eigen::Vector3d& target_m, double age_s);
  void forget();
  /// Of the TargetTrack. A known motion is dropped: it may be that of a head that oscillates.
  void set_time_constant(double time_constant_s);

  [[nodiscard]] bool is_known() const { return track_.is_known(); }  ///< otherwise predictions have no meaning
  /// The target `lead_s` after the current time.
  [[nodiscard]] TargetMotion predict(double lead_s) const;
  /// The sinusoid in use.
  [[nodiscard]] const std::optional<Sinusoid>& sinusoid() const { return sinusoid_; }
  [[nodiscard]] bool falls() const { return fall_.has_value(); }

 private:
  struct Known {
    Eigen::Vector3d position_m, velocity_m_s, acceleration_m_s2;
  };
  [[nodiscard]] Known known_at(double t_s) const;
  void use(const std::optional<Sinusoid>& sinusoid, const std::optional<FreeFall>& fall);
  void update_motion();

  double time_constant_s_;
  bool models_;
  TargetTrack track_;
  PeriodicFit fit_;
  std::optional<Sinusoid> sinusoid_;
  std::optional<FreeFall> fall_;
  double now_s_ = 0.0;
  double age_s_ = 0.0;            ///< of the newest target
  double falling_s_ = 0.0;        ///< for how long the track's acceleration has been that of gravity
  double distance_m_ = 0.0;       ///< mean distance between observations and predictions
  double rejected_until_s_ = 0.0;  ///< no sinusoid is used before
};

}  // namespace saccade
