#pragma once

#include "control/locating_gate.h"

namespace saccade {

/// `none`: every estimate at or above the threshold, a held one too, becomes a target.
class OpenGate final : public LocatingGate {
 public:
  using LocatingGate::LocatingGate;

  std::optional<Eigen::Vector3d> update(std::int64_t, const Estimate& estimate, double threshold,
                                        const Camera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override {
    if (!is_detection(estimate, threshold)) return std::nullopt;
    return locate(estimate.circle, camera, root_from_cam);
  }
};

}  // namespace saccade
