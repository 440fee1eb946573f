#pragma once

#include "control/gaze_gate.h"

namespace saccade {

/// Whether an estimate counts as a detection: valid, and its score at or above the threshold (a NaN is not).
[[nodiscard]] inline bool is_detection(const Estimate& estimate, double threshold) {
  return estimate.valid && estimate.score >= threshold;
}

/// A gate that makes points of circles with a TargetLocator and counts the circles that give no target.
class LocatingGate : public GazeGate {
 public:
  explicit LocatingGate(const TargetConfig& config) : locator_(config) {}
  [[nodiscard]] RejectedTargets rejected() const override { return rejected_; }

 protected:
  /// The target of a circle, m, root frame; none and counted where there is none.
  std::optional<Eigen::Vector3d> locate(const Circle& circle, const Camera& camera,
                                        const Eigen::Isometry3d& root_from_cam) {
    const Target target = locator_.locate(circle, camera, root_from_cam);
    if (target.status == TargetStatus::ok) return target.point_m;
    count(target.status);
    return std::nullopt;
  }
  void count(TargetStatus status) {
    rejected_.not_finite += status == TargetStatus::not_finite;
    rejected_.bad_radius += status == TargetStatus::bad_radius;
    rejected_.too_near += status == TargetStatus::too_near;
    rejected_.behind += status == TargetStatus::behind;
    rejected_.too_far += status == TargetStatus::too_far;
    rejected_.in_body += status == TargetStatus::in_body;
  }

 private:
  TargetLocator locator_;
  RejectedTargets rejected_;
};

}  // namespace saccade
