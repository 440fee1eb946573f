#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

#include "core/units.h"
#include "robot/ports.h"

namespace saccade {

/// The reference at which a head stops: the newest positions, inside the limits. A joint whose position is missing or not
/// finite (its encoder fails) stops at its last reference; std::nullopt if nothing was sent yet. Joints are the first `joints`
/// that gaze commands, at most gaze_slots; `last_reference_deg` has as many or is empty before the first command.
[[nodiscard]] inline std::optional<HeadCommand> stop_reference(std::span<const double> position_deg,
                                                               std::span<const double> last_reference_deg,
                                                               int joints, const JointLimits& limits) {
  HeadCommand reference_rad = HeadCommand::Zero();
  for (int i = 0; i < joints; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool is_read = at < position_deg.size() && std::isfinite(position_deg[at]);
    if (!is_read && at >= last_reference_deg.size()) return std::nullopt;
    reference_rad[i] = (is_read ? position_deg[at] : last_reference_deg[at]) * rad_per_deg;
  }
  return reference_rad.cwiseMax(limits.min_rad.tail<gaze_slots>())
      .cwiseMin(limits.max_rad.tail<gaze_slots>());
}

}  // namespace saccade
