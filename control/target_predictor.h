#pragma once

#include <optional>

#include "control/free_fall.h"
#include "control/periodic_fit.h"
#include "control/recent_path.h"
#include "control/straight_path.h"
#include "control/target_track.h"

namespace saccade {

/// Position and velocity of a target at one time.
struct TargetMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< root frame
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< root frame
};

/// Predicts a gaze target from its last observations, which may be old.
///
/// The target's motion is split into a known motion and what is left of it. The known motion is a sinusoid (PeriodicFit) or
/// free fall, and none while neither fits; it is extrapolated exactly. A TargetTrack follows the rest, so that it lags
/// only behind the rest: without a known motion the estimate is that of the TargetTrack. When the known motion changes,
/// the track is shifted, so that the estimate is continuous.
///
/// When no target has come for 60 ms and no motion is known, the target may be covered: for up to 1 s it is then
/// extrapolated along the straight line of its path until shortly before (StraightPath), if it moved so, and rests at the
/// end of it. The next target ends that.
///
/// A known motion is dropped when observations leave it, or when no target came for 1 s (free fall: 0.5 s). They leave it
/// when the mean distance over 30 ms between observations and predictions exceeds a quarter of the sinusoid's amplitude
/// (free fall: 2 cm), or the rest twice that.
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

  [[nodiscard]] bool is_known() const {
    return track_.is_known();
  }  ///< otherwise predictions have no meaning
  /// The target `lead_s` after the current time.
  [[nodiscard]] TargetMotion predict(double lead_s) const;
  /// The sinusoid in use.
  [[nodiscard]] const std::optional<Sinusoid>& sinusoid() const { return sinusoid_; }
  [[nodiscard]] bool falls() const { return fall_.has_value(); }

 private:
  struct Known {
    Eigen::Vector3d position_m, velocity_m_s, acceleration_m_s2;
  };
  [[nodiscard]] double longest_gap() const;
  [[nodiscard]] Known known_at(double t_s) const;
  void use(const std::optional<Sinusoid>& sinusoid, const std::optional<FreeFall>& fall,
           const std::optional<StraightPath>& line = {});
  [[nodiscard]] bool leaves_known_motion() const;
  void update_known_motion(bool new_average);
  void forget_path();

  double time_constant_s_;
  bool models_;
  TargetTrack track_;
  RecentPath path_;
  PeriodicFit fit_;
  std::optional<Sinusoid> sinusoid_;
  std::optional<FreeFall> fall_;
  std::optional<StraightPath> line_;  ///< since targets are missing
  bool line_was_fitted_ = false;      ///< since then
  double now_s_ = 0.0;
  double age_s_ = 0.0;             ///< of the newest target
  double distance_m_ = 0.0;        ///< mean distance between observations and predictions
  double rejected_until_s_ = 0.0;  ///< no known motion is used before
};

}  // namespace saccade
