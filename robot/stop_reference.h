#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "head/head_state.h"

namespace saccade {

/// The reference that stops a head: the newest finite position of each joint, moved inside the limits. A joint whose
/// encoder fails stops at its last known position.
class StopReference {
 public:
  /// A reading of the head; positions that are not finite have no effect.
  void update(const HeadState& state) {
    const HeadJointVector position_rad = state.head_position_rad();
    for (Eigen::Index j = 0; j < head_joint_count; ++j) {
      if (std::isfinite(position_rad[j])) position_rad_[j] = position_rad[j];
    }
  }
  /// Rad, neck pitch to eyes vergence. None before each joint had a finite position.
  [[nodiscard]] std::optional<HeadJointVector> reference_rad(const JointLimits& limits) const {
    if (!position_rad_.allFinite()) return std::nullopt;
    return position_rad_.cwiseMax(limits.min_rad.tail<head_joint_count>())
        .cwiseMin(limits.max_rad.tail<head_joint_count>());
  }

 private:
  HeadJointVector position_rad_ = HeadJointVector::Constant(std::numeric_limits<double>::quiet_NaN());
};

}  // namespace saccade
