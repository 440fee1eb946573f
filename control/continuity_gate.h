#pragma once

#include <array>
#include <cstdint>

#include "control/locating_gate.h"
#include "control/target_predictor.h"
#include "control/target_track.h"

namespace saccade {

/// A ball does not jump: once found, a detection near the last one becomes a target at once and one elsewhere does not;
/// to be found, and found again after it was lost, the ball has to be confirmed by detections that agree. All in the root
/// frame, so that the head's own motion has no effect, and as angles at the eye, because depth from a radius is coarse.
struct ContinuityGateConfig {
  double tolerance_deg = 3.0;  ///< detections this close in bearing agree ...
  double depth_ratio = 1.25;   ///< ... if their distances differ by less than this factor
  /// The tolerance around the last one grows by this while none came, or by one and a half times the speed of the targets
  /// of the last half second where that is more. That of the distance is multiplied by exp of the same angle in rad.
  double growth_deg_s = 60.0;
  double window_s = 0.20;          ///< how far back a confirmation may lie
  std::int64_t min_agreeing = 60;  ///< in the window, for the ball to be found
  double forget_s = 2.0;           ///< after so long without a detection near by the ball is lost
  /// Share of the threshold from which on a score suffices where the circle agrees with the predicted place, unless the targets
  /// of the last half second moved by more than near_deg in 45 ms; 1: no score below the threshold does.
  double near_score = 0.2;
  double near_deg = 2.0;  ///< largest angle between such a circle and the prediction
  double near_s = 2.0;    ///< after so long without a detection at the threshold such circles count no more
};

/// Keys: tolerance_deg, depth_ratio, growth_deg_s, window_s, min_agreeing, forget_s, near_score, near_deg, near_s.
void describe(FieldVisitor& v, ContinuityGateConfig& config);

/// `continuity`: the estimates at or above the threshold that lie where the ball can be become targets; at a distance that it
/// can't have reached, in a direction that it can have, where they are confirmed. Estimates with a lower score do too, once the
/// ball was found: those within near_deg of the place that a TargetPredictor (with periodic motion and free fall) computes from
/// the targets so far, of a detector that tracks circles and states their covariance; their target has the distance of the last.
/// Low scores of other detectors are clutter.
class ContinuityGate final : public LocatingGate {
 public:
  /// Throws InputError for a configuration out of range.
  ContinuityGate(const ContinuityGateConfig& config, const TargetConfig& target);

  std::optional<Eigen::Vector3d> update(std::int64_t now_us, const Estimate& estimate, double threshold,
                                        const Camera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override;

 private:
  struct Place {
    std::int64_t t_us = 0;
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  };
  static constexpr std::size_t capacity = 1024;  // the longest window at one detection per ms

  [[nodiscard]] bool confirmed(const Place& here, const Eigen::Vector3d& eye_m) const;
  [[nodiscard]] bool can_have_reached(const Place& here, const Eigen::Vector3d& eye_m) const;
  void advance(std::int64_t now_us);
  void accept(const Place& here, const Eigen::Vector3d& eye_m);
  [[nodiscard]] std::optional<Eigen::Vector3d> near_prediction(std::int64_t now_us, const Estimate& estimate,
                                                               double threshold, const Camera& camera,
                                                               const Eigen::Isometry3d& root_from_cam);
  [[nodiscard]] bool agree(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m,
                           const Eigen::Vector3d& eye_m, double tolerance_deg) const;

  ContinuityGateConfig config_;
  std::int64_t window_us_;
  std::int64_t forget_us_;
  std::array<Place, capacity> recent_{};
  std::size_t count_ = 0;
  std::optional<Place> last_;
  TargetTrack track_;                         ///< of the targets
  double fastest_rad_s_ = 0.0;                ///< the target, lately
  std::optional<TargetPredictor> predictor_;  ///< with near_score below 1
  std::int64_t advanced_us_ = 0;              ///< to when both have advanced
  std::int64_t sure_us_ = 0;                  ///< the last target at the threshold
};

}  // namespace saccade
